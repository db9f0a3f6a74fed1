#include "embedding/mesh_record/mesh_materials.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

namespace umax {

void settle_materials(MeshFile& file, const std::vector<char>& has_coordinates) {
  const auto num_triangles = std::size_t(file.mesh.num_triangles());
  std::vector<int>& of_triangle = file.mesh.materials;
  if (of_triangle.empty()) of_triangle.assign(num_triangles, 0);
  std::map<std::pair<int, bool>, int> kept;
  std::vector<MeshMaterial> materials;
  for (std::size_t t = 0; t < num_triangles; ++t) {
    const int old = of_triangle[t];
    const bool known = old >= 0 && old < int(file.materials.size());
    const bool drawn = has_coordinates.empty() || has_coordinates[t];
    const auto [place, is_new] = kept.try_emplace({known ? old : -1, drawn}, int(materials.size()));
    of_triangle[t] = place->second;
    if (!is_new) continue;
    materials.push_back(known ? file.materials[std::size_t(old)] : MeshMaterial{});
    if (drawn) continue;
    materials.back().texture.clear();
    materials.back().embedded_texture = -1;
  }
  const bool says_something =
      std::any_of(materials.begin(), materials.end(), [](const MeshMaterial& m) { return m.has_color(); });
  file.materials = says_something ? std::move(materials) : std::vector<MeshMaterial>{};
  if (file.materials.size() < 2) of_triangle.clear();
}

namespace {

/// "a b" of "a%20b", as addresses in glTF are written.
std::string without_escapes(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    int code = 0;
    const char* digits = text.data() + i + 1;
    const bool escaped =
        text[i] == '%' && i + 2 < text.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2;
    plain += escaped ? char(code) : text[i];
    if (escaped) i += 2;
  }
  return plain;
}

}  // namespace

std::filesystem::path find_texture(const std::filesystem::path& mesh_file, std::string name,
                                   std::vector<std::string>& notes) {
  namespace fs = std::filesystem;
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path folder = mesh_file.parent_path();
  std::error_code error;
  const std::string plain = without_escapes(name);
  for (const fs::path& candidate : {folder / name, folder / plain, folder / fs::path(plain).filename()})
    if (fs::is_regular_file(candidate, error)) return fs::absolute(candidate).lexically_normal();
  const std::string note = "the texture " + name + " that the mesh names does not exist: drawn in the plain colour";
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  return {};
}

}  // namespace umax
