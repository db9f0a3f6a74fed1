#include "embedding/caches/moving_surface.h"

#include <algorithm>

namespace umax {
namespace {

std::string plain_name(const std::string& name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  std::string out = name.empty() ? "material" : name;
  std::replace_if(out.begin(), out.end(), [&](char c) { return !is_plain(c); }, '_');
  return out;
}

}  // namespace

std::vector<int> MovingSurface::triangles_of(std::size_t material) const {
  std::vector<int> found;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    if (material_of(t) == material) found.push_back(int(t));
  return found;
}

std::vector<std::string> MovingSurface::textures() const {
  std::vector<std::string> found;
  for (const SurfaceMaterial& material : materials)
    if (!material.texture.empty() && std::find(found.begin(), found.end(), material.texture) == found.end())
      found.push_back(material.texture);
  return found;
}

std::vector<std::string> material_names(const std::vector<std::string>& wanted) {
  std::vector<std::string> names;
  for (const std::string& name : wanted) {
    const std::string plain = plain_name(name);
    std::string free = plain;
    for (int number = 2; std::find(names.begin(), names.end(), free) != names.end(); ++number)
      free = plain + "_" + std::to_string(number);
    names.push_back(free);
  }
  return names;
}

}  // namespace umax
