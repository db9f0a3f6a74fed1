#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <streambuf>
#include <string_view>

#include "core/base/srgb.h"
#include "core/files/read_file.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/mesh_record/mesh_materials.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  for (std::size_t at = 0; at < line.size();) {
    at = line.find_first_not_of(" \t\r", at);
    if (at == line.npos) break;
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    result.push_back(line.substr(at, end - at));
    at = end;
  }
  return result;
}

[[noreturn]] void refuse_line(const Path& path, long long line, const std::string& what, std::string_view text) {
  refuse_mesh(path.string() + ":" + std::to_string(line), what, '"' + std::string(text.substr(0, 60)) + '"',
              "the file is truncated or damaged: export it again");
}

bool says_nan_or_infinity(std::string_view word) {
  if (!word.empty() && (word[0] == '-' || word[0] == '+')) word.remove_prefix(1);
  std::string start(word.substr(0, 3));
  for (char& c : start) c = char(std::tolower(static_cast<unsigned char>(c)));
  return start == "nan" || start == "inf";
}

void check_coordinate(const Path& path, long long line_number, std::string_view line, std::string_view word,
                      long long vertex) {
  double value = 0;
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool too_large = error == std::errc::result_out_of_range;
  if (!too_large && (error != std::errc() || end != word.data() + word.size()))
    refuse_line(path, line_number, fmt::format("vertex {} has a coordinate that is no number", vertex), line);
}

/// A corner: "7", "7/2", "7//3" or "7/2/3", numbers that an int holds.
void check_corner(const Path& path, long long line_number, std::string_view line, std::string_view corner) {
  while (!corner.empty()) {
    const std::size_t length = std::min(corner.find('/'), corner.size());
    std::string_view index = corner.substr(0, length);
    corner.remove_prefix(std::min(length + 1, corner.size()));
    if (index.starts_with('+')) index.remove_prefix(1);
    int value = 0;
    const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), value);
    if (error == std::errc::result_out_of_range)
      refuse_line(path, line_number, "a face names a vertex beyond all that can be counted", line);
    if (!index.empty() && (error != std::errc() || end != index.data() + index.size()))
      refuse_line(path, line_number, "a face has a corner that is no number", line);
  }
}

// The reader takes what it cannot read for 0 and leaves out faces it does not understand; so the lines that matter are
// looked at first. Counts vertices that are not finite.
void check_lines(const Path& path, std::string_view text) {
  long long line_number = 0, num_vertices = 0, num_bad = 0, first_bad = -1;
  std::string_view first_bad_line;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    ++line_number;
    const std::size_t start = std::min(line.find_first_not_of(" \t"), line.size());
    if (start + 1 >= line.size() || (line[start] != 'v' && line[start] != 'f') ||
        (line[start + 1] != ' ' && line[start + 1] != '\t'))
      continue;
    const auto parts = words(line);
    if (line[start] == 'f') {
      if (parts.size() < 4) refuse_line(path, line_number, "a face needs at least three corners", line);
      for (std::size_t corner = 1; corner < parts.size(); ++corner)
        check_corner(path, line_number, line, parts[corner]);
      continue;
    }
    if (parts.size() < 4)
      refuse_line(path, line_number, fmt::format("vertex {} needs three coordinates", num_vertices), line);
    bool finite = true;
    for (std::size_t axis = 1; axis < 4; ++axis) {
      const bool is_finite = !says_nan_or_infinity(parts[axis]);
      finite &= is_finite;
      if (is_finite) check_coordinate(path, line_number, line, parts[axis], num_vertices);
    }
    if (!finite && num_bad++ == 0) {
      first_bad = num_vertices;
      first_bad_line = line;
    }
    ++num_vertices;
  }
  if (num_bad > 0)
    refuse_mesh(path,
                fmt::format("{} of {} vertices are not finite numbers, the first is vertex {}", num_bad, num_vertices,
                            first_bad),
                '"' + std::string(first_bad_line.substr(0, 60)) + '"', "repair or export the mesh again");
}

// vertices as in the file; colours only if some vertex has one
void take_vertices(const tinyobj::attrib_t& attributes, TriangleMesh& mesh) {
  const Eigen::Index num_vertices = Eigen::Index(attributes.vertices.size() / 3);
  mesh.positions = Eigen::Map<const Points>(attributes.vertices.data(), num_vertices, 3);
  if (Eigen::Index(attributes.colors.size()) == 3 * num_vertices && num_vertices > 0)
    mesh.colors =
        Eigen::Map<const Points>(attributes.colors.data(), num_vertices, 3).unaryExpr(&linear_from_srgb<double>);
}

/// A `\` at the end of a line: it goes on in the next. Line ends come behind the whole, so that what follows keeps its
/// number. Comments do not go on: paths in them end like that.
void join_continued_lines(std::string& text) {
  if (text.find("\\\n") == text.npos && text.find("\\\r\n") == text.npos) return;
  std::string joined;
  joined.reserve(text.size());
  std::size_t line_ends = 1;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = std::string_view(text).substr(at, end - at);
    if (line.ends_with('\r')) line.remove_suffix(1);
    const bool goes_on = line.ends_with('\\') && end < text.size() && !line.starts_with('#');
    if (goes_on) line.remove_suffix(1);
    joined += line;
    joined.append(goes_on ? 1 : line_ends, goes_on ? ' ' : '\n');
    line_ends = goes_on ? line_ends + 1 : 1;
    at = end + 1;
  }
  text = std::move(joined);
}

/// The text as a stream that copies nothing.
class TextBuffer : public std::streambuf {
 public:
  explicit TextBuffer(std::string& text) { setg(text.data(), text.data(), text.data() + text.size()); }
};

/// Reads material files; Kd = -1 where a file says none. Those that are not there are noted.
class Materials : public tinyobj::MaterialReader {
 public:
  Materials(const Path& mesh_file, std::vector<std::string>& notes) : mesh_file_(mesh_file), notes_(notes) {}

  bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* places, std::string* warnings, std::string* errors) override {
    std::string slashed = name;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    std::ifstream file(mesh_file_.parent_path() / slashed, std::ios::binary);
    if (!file) {
      notes_.push_back("the materials " + name + " that the mesh names do not exist: drawn in the plain colour");
      return true;
    }
    std::stringstream marked;
    for (std::string line; std::getline(file, line);) {
      marked << line << '\n';
      if (line.find("newmtl") != line.npos) marked << "Kd -1 -1 -1\n";
    }
    tinyobj::LoadMtl(places, materials, &marked, warnings, errors);
    return true;
  }

 private:
  Path mesh_file_;
  std::vector<std::string>& notes_;
};

MeshMaterial material_of(const Path& path, const tinyobj::material_t& material, std::vector<std::string>& notes) {
  MeshMaterial result{.name = material.name};
  const Vector3d color = Eigen::Map<const Vector3d>(material.diffuse);
  if ((color.array() >= 0).all() && color.allFinite()) result.color = color.cwiseMin(1.0);
  if (!material.diffuse_texname.empty()) result.texture = find_texture(path, material.diffuse_texname, notes);
  return result;
}

void take_materials(const Path& path, const std::vector<tinyobj::shape_t>& shapes,
                    const std::vector<tinyobj::material_t>& materials, MeshFile& file) {
  std::vector<int> place(materials.size(), -1);
  std::vector<char> has_coordinates;
  for (const tinyobj::shape_t& shape : shapes)
    for (std::size_t t = 0; t < shape.mesh.material_ids.size(); ++t) {
      const int id = shape.mesh.material_ids[t];
      const bool known = id >= 0 && id < int(materials.size());
      if (known && place[std::size_t(id)] < 0) {
        place[std::size_t(id)] = int(file.materials.size());
        file.materials.push_back(material_of(path, materials[std::size_t(id)], file.notes));
      }
      file.mesh.materials.push_back(known ? place[std::size_t(id)] : -1);
      bool all = true;
      for (std::size_t k = 3 * t; k < 3 * t + 3; ++k) all &= shape.mesh.indices[k].texcoord_index >= 0;
      has_coordinates.push_back(all);
    }
  settle_materials(file, has_coordinates);
}

void take_faces(const Path& path, const tinyobj::attrib_t& attributes, const std::vector<tinyobj::shape_t>& shapes,
                TriangleMesh& mesh) {
  std::size_t num_corners = 0;
  bool some_have_texture = false;
  for (const tinyobj::shape_t& shape : shapes) {
    num_corners += shape.mesh.indices.size();
    for (const tinyobj::index_t& index : shape.mesh.indices) some_have_texture |= index.texcoord_index >= 0;
  }
  if (num_corners > std::size_t(std::numeric_limits<int>::max()))
    refuse_mesh(path, "the mesh has more triangles than can be counted", std::to_string(num_corners / 3), "reduce it");
  mesh.triangles.resize(Eigen::Index(num_corners / 3), 3);
  if (some_have_texture) mesh.texture_coordinates = TextureCoordinates::Zero(Eigen::Index(num_corners), 2);

  Eigen::Index corner = 0;
  for (const tinyobj::shape_t& shape : shapes)
    for (const tinyobj::index_t& index : shape.mesh.indices) {
      mesh.triangles(corner / 3, corner % 3) = index.vertex_index;
      if (index.texcoord_index >= 0) {
        const std::size_t t = 2 * std::size_t(index.texcoord_index);
        if (t + 1 >= attributes.texcoords.size())
          refuse_mesh(path, "a face names a texture coordinate that does not exist",
                      std::to_string(index.texcoord_index + 1), "export the mesh again");
        mesh.texture_coordinates.row(corner) << float(attributes.texcoords[t]), float(attributes.texcoords[t + 1]);
      }
      ++corner;
    }
}

}  // namespace

MeshFile read_obj(const Path& path) {
  std::string text = read_file(path);
  join_continued_lines(text);
  check_lines(path, text);
  MeshFile file;
  TextBuffer buffer(text);
  std::istream stream(&buffer);
  Materials reader(path, file.notes);
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warnings, errors;
  const bool sound = tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, &stream, &reader,
                                      /*triangulate=*/true, /*default_vcols_fallback=*/false);
  if (!sound) refuse_mesh(path, "not a sound OBJ file", errors.substr(0, errors.find('\n')), "export the mesh again");
  for (const char* fault : {"out of bounds", "invalid vertex index"})
    if (warnings.find(fault) != warnings.npos)
      refuse_mesh(path, "a face names a vertex that does not exist",
                  std::to_string(attributes.vertices.size() / 3) + " vertices",
                  "the file is truncated or damaged: export it again");

  take_vertices(attributes, file.mesh);
  take_faces(path, attributes, shapes, file.mesh);
  file.num_parts =
      int(std::count_if(shapes.begin(), shapes.end(), [](const auto& shape) { return !shape.mesh.indices.empty(); }));
  take_materials(path, shapes, materials, file);
  return file;
}

}  // namespace umax
