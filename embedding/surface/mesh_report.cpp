#include "embedding/surface/mesh_report.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "embedding/surface/topology.h"

namespace umax {
namespace {

void count_edges(const TriangleMesh& mesh, const std::vector<int>& welded, MeshReport& report) {
  for_each_edge(edge_uses(mesh.triangles, welded), [&](auto first, auto last) {
    const auto count = last - first;
    if (count == 1) ++report.num_boundary_edges;
    if (count > 2) ++report.num_non_manifold_edges;
    if (count == 2 && first[0].forward == first[1].forward) ++report.num_inconsistent_edges;
  });
}

void count_vertices(const TriangleMesh& mesh, const std::vector<int>& welded, MeshReport& report) {
  std::vector<char> used(welded.size(), 0);
  for (int corner : mesh.triangles.reshaped()) used[corner] = 1;
  for (std::size_t v = 0; v < welded.size(); ++v) {
    if (!used[v]) ++report.num_unused_vertices;
    if (welded[v] != int(v)) ++report.num_duplicate_vertices;
  }
}

void measure_triangles(const TriangleMesh& mesh, const std::vector<int>& welded, MeshReport& report) {
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Vector3d a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                   c = mesh.positions.row(mesh.triangles(t, 2));
    const double twice_area = (b - a).cross(c - a).norm();
    report.area += 0.5 * twice_area;
    const int i = welded[mesh.triangles(t, 0)], j = welded[mesh.triangles(t, 1)], k = welded[mesh.triangles(t, 2)];
    if (i == j || j == k || k == i || !(twice_area > 0)) ++report.num_degenerate_triangles;
  }
}

void list_problems(MeshReport& report) {
  const auto add = [&](int count, const char* one, const char* many) {
    if (count > 0) report.problems.push_back(count == 1 ? fmt::format("1 {}", one) : fmt::format("{} {}", count, many));
  };
  add(report.num_boundary_edges, "boundary edge: the surface is open", "boundary edges: the surface is open");
  add(report.num_non_manifold_edges, "edge with more than two triangles", "edges with more than two triangles");
  add(report.num_inconsistent_edges, "edge whose triangles run the same way: their normals disagree",
      "edges whose triangles run the same way: their normals disagree");
  add(report.num_degenerate_triangles, "triangle without area", "triangles without area");
  add(report.num_unused_vertices, "vertex in no triangle", "vertices in no triangle");
  if (report.watertight && report.signed_volume < 0) report.problems.push_back("the surface is inside out");
}

}  // namespace

MeshReport report_mesh(const TriangleMesh& mesh) {
  MeshReport report;
  if (mesh.num_vertices() == 0) return report;
  const std::vector<int> welded = weld(mesh.positions);
  report.box_min = mesh.positions.colwise().minCoeff();
  report.box_max = mesh.positions.colwise().maxCoeff();
  report.num_parts = triangle_components(mesh.triangles, welded).second;
  report.signed_volume = signed_volume(mesh.positions, mesh.triangles);
  count_edges(mesh, welded, report);
  count_vertices(mesh, welded, report);
  measure_triangles(mesh, welded, report);
  report.watertight = mesh.num_triangles() > 0 && report.num_boundary_edges == 0 &&
                      report.num_non_manifold_edges == 0 && report.num_inconsistent_edges == 0;
  list_problems(report);
  return report;
}

}  // namespace umax
