#include "embedding/mesh_files/mesh_assembly.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "core/base/srgb.h"
#include "embedding/mesh_files/polygon.h"
#include "embedding/scanning/file_checks.h"

namespace umax {

void MeshAssembly::add_polygon(const std::filesystem::path& path, long long number, const std::vector<int>& corners) {
  const Eigen::Index num_vertices = file.mesh.num_vertices();
  for (const int corner : corners)
    if (corner < 0 || corner >= num_vertices)
      refuse_mesh(path, fmt::format("face {} names vertex {}, which does not exist", number, corner),
                  fmt::format("{} vertices", num_vertices), "the file is damaged: export it again");
  cut.clear();
  if (corners.size() == 3)
    cut.push_back({0, 1, 2});
  else
    cut_polygon(file.mesh.positions, corners, cut);
  for (const auto& [a, b, c] : cut)
    triangles.push_back({corners[std::size_t(a)], corners[std::size_t(b)], corners[std::size_t(c)]});
}

MeshFile MeshAssembly::finish(const std::filesystem::path& path) {
  if (triangles.size() > std::size_t(std::numeric_limits<int>::max()) / 3)
    refuse_mesh(path, "the mesh has more triangles than can be counted", std::to_string(triangles.size()), "reduce it");
  TriangleMesh& mesh = file.mesh;
  mesh.triangles.resize(Eigen::Index(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    mesh.triangles.row(Eigen::Index(t)) = Eigen::Map<const Eigen::RowVector3i>(triangles[t].data());
  if (coordinates.size() == 3 * triangles.size()) {
    mesh.texture_coordinates.resize(Eigen::Index(coordinates.size()), 2);
    for (std::size_t c = 0; c < coordinates.size(); ++c)
      mesh.texture_coordinates.row(Eigen::Index(c)) = coordinates[c].transpose();
  }
  file.num_parts = 1;
  return std::move(file);
}

Points linear_colors(const Points& stored) {
  const double scale = stored.size() > 0 && stored.maxCoeff() > 1 ? 255 : 1;
  return (stored / scale).unaryExpr(&linear_from_srgb<double>);
}

}  // namespace umax
