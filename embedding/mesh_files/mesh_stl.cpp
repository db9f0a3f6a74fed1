// STL, text and binary: three vertices a facet, in the file's order.
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <limits>

#include "core/files/read_file.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/scanning/mesh_scanner.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

constexpr std::size_t header_size = 84, facet_size = 50, normal_size = 12;  // [bytes]

[[noreturn]] void refuse_truncated(const Path& path, const std::string& found) {
  refuse_mesh(path, "the mesh file is truncated", found, "copy or export it again");
}

/// Both say "solid" as a rule; text goes on with a facet.
bool is_text(std::string_view bytes) {
  return bytes.starts_with("solid") && bytes.substr(0, 1100).find("facet") != bytes.npos;
}

MeshFile with_facets(const Path& path, const std::vector<float>& coordinates) {
  const std::size_t num_vertices = coordinates.size() / 3;
  if (num_vertices > std::size_t(std::numeric_limits<int>::max()))
    refuse_mesh(path, "the mesh has more vertices than can be counted", std::to_string(num_vertices), "reduce it");
  MeshFile file;
  TriangleMesh& mesh = file.mesh;
  mesh.positions = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(
                       coordinates.data(), Eigen::Index(num_vertices), 3)
                       .cast<double>();
  mesh.triangles.resize(Eigen::Index(num_vertices / 3), 3);
  for (Eigen::Index corner = 0; corner < mesh.triangles.size(); ++corner) mesh.triangles.data()[corner] = int(corner);
  file.num_parts = 1;
  return file;
}

MeshFile read_binary(const Path& path, std::string_view bytes) {
  if (bytes.size() < header_size) refuse_truncated(path, fmt::format("{} bytes", bytes.size()));
  std::uint32_t num_facets = 0;
  std::memcpy(&num_facets, bytes.data() + header_size - sizeof num_facets, sizeof num_facets);
  const std::size_t promised = header_size + facet_size * num_facets;
  if (bytes.size() < promised) refuse_truncated(path, fmt::format("{} of {} bytes", bytes.size(), promised));
  std::vector<float> coordinates(9 * std::size_t(num_facets));
  for (std::size_t f = 0; f < num_facets; ++f)
    std::memcpy(&coordinates[9 * f], bytes.data() + header_size + facet_size * f + normal_size, 9 * sizeof(float));
  return with_facets(path, coordinates);
}

MeshFile read_text(const Path& path, std::string_view bytes) {
  const std::size_t end = bytes.size() > 1024 ? bytes.size() - 1024 : 0;
  if (bytes.substr(end).find("endsolid") == bytes.npos) refuse_truncated(path, "no \"endsolid\"");
  MeshScanner scan(path, bytes);
  std::vector<float> coordinates;
  int num_parts = 0;
  while (!scan.at_end()) {
    const std::string_view word = scan.word();
    if (word == "vertex") {
      for (int axis = 0; axis < 3; ++axis) coordinates.push_back(float(scan.number("a coordinate")));
      continue;
    }
    num_parts += word == "solid";
    if (word == "endloop" && coordinates.size() % 9 != 0) scan.refuse("has a loop of other than three vertices");
    scan.line();  // names and normals
  }
  if (coordinates.size() % 9 != 0) scan.refuse("has a loop of other than three vertices");
  MeshFile file = with_facets(path, coordinates);
  file.num_parts = num_parts;
  return file;
}

}  // namespace

MeshFile read_stl(const Path& path) {
  const std::string bytes = read_file(path);
  return is_text(bytes) ? read_text(path, bytes) : read_binary(path, bytes);
}

}  // namespace umax
