#include "embedding/surface/solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "embedding/surface/topology.h"

namespace umax {
namespace {

using GridPoint = std::array<int, 3>;

constexpr double agreement = 0.02;  // [-] of volumes

// whether two volumes [m^3] are the same but for the means of measuring; slack [m^3]: what counts as nothing
bool agree(double a, double b, double slack) {
  if (std::max(std::abs(a), std::abs(b)) <= slack) return true;
  return std::abs(a - b) <= agreement * std::max(std::abs(a), std::abs(b));
}

void note_faults(const ClosedSurface& surface, std::vector<std::string>& notes) {
  if (surface.num_boundary_edges > 0)
    notes.push_back(fmt::format("the surface is open: {} boundary edge{} around {} hole{}", surface.num_boundary_edges,
                                surface.num_boundary_edges == 1 ? "" : "s", surface.num_holes,
                                surface.num_holes == 1 ? "" : "s"));
  if (surface.num_turned > 0)
    notes.push_back(fmt::format("{} triangle{} faced against the neighbours and {} turned to find the inside",
                                surface.num_turned, surface.num_turned == 1 ? "" : "s",
                                surface.num_turned == 1 ? "was" : "were"));
}

// The level set fills whatever cannot be reached from outside, so it loses an open mesh and fills closed cavities; the
// winding number cannot see a surface whose triangles do not share vertices. Volumes tell which one to believe.
bool trust_level_set(const TriangleMesh& mesh, const Solid& solid, double winding_volume, double slack) {
  if (agree(solid.level_set_volume, winding_volume, slack)) return true;
  if (solid.surface.num_boundary_edges == 0) return false;
  const double open_volume = std::abs(signed_volume(mesh.positions, mesh.triangles));
  return solid.level_set_volume > 1.25 * winding_volume && agree(solid.level_set_volume, open_volume, slack);
}

// [-] voxels in a narrow band of three on both sides
double band_voxels(double area, double voxel) {
  return 8 * area / (voxel * voxel);
}

// The level set takes each triangle's voxels one by one: thousands of triangles that are long and thin, or lie over each
// other, take far longer than their area says.
bool is_long_work(const TriangleMesh& mesh, double voxel) {
  constexpr double long_edge = 8, most = 1e6;  // [voxels]
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    double longest = 0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest,
          (mesh.positions.row(mesh.triangles(t, k)) - mesh.positions.row(mesh.triangles(t, (k + 1) % 3))).norm() /
              voxel);
    if (longest > long_edge) sum += longest;
  }
  return sum > most;
}

// The triangles with the first vertex of each small cube in the place of all others there; each once.
Triangles merged_within(const TriangleMesh& mesh, double edge) {
  const Eigen::Index num_vertices = mesh.num_vertices();
  const Eigen::RowVector3d low = mesh.positions.colwise().minCoeff();
  Points cubes(num_vertices, 3);
  for (Eigen::Index v = 0; v < num_vertices; ++v) cubes.row(v) = ((mesh.positions.row(v) - low) / edge).array().floor();
  const std::vector<int> first = weld(cubes);
  std::vector<std::array<int, 3>> corners;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    std::array<int, 3> of{first[mesh.triangles(t, 0)], first[mesh.triangles(t, 1)], first[mesh.triangles(t, 2)]};
    std::sort(of.begin(), of.end());
    if (of[0] != of[1] && of[1] != of[2]) corners.push_back(of);
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  Triangles triangles(Eigen::Index(corners.size()), 3);
  for (std::size_t t = 0; t < corners.size(); ++t)
    triangles.row(Eigen::Index(t)) << corners[t][0], corners[t][1], corners[t][2];
  return triangles;
}

std::vector<char> inside_by_level_set(const LevelSet& level_set, const PointGrid& grid,
                                      const std::vector<GridPoint>& points) {
  Points positions(Eigen::Index(points.size()), 3);
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int axis = 0; axis < 3; ++axis)
      positions(Eigen::Index(p), axis) = grid.origin[axis] + points[p][std::size_t(axis)] * grid.spacing[axis];
  const std::vector<float> distances = level_set.sample(positions);
  std::vector<char> inside(points.size());
  std::transform(distances.begin(), distances.end(), inside.begin(), [](float d) { return char(d < 0); });
  return inside;
}

// walks the grid's lines along z and marks the points on every stretch that is inside
std::vector<char> inside_by_winding(const ClosedSurface& surface, const PointGrid& grid,
                                    const std::vector<GridPoint>& points) {
  std::vector<char> inside(points.size(), 0);
  const LineGrid lines{.origin = grid.origin.head<2>(), .spacing = grid.spacing.head<2>(), .size = grid.size.head<2>()};
  visit_inside(surface, lines, [&](int i, int j, double z0, double z1) {
    const double last_k = double(grid.size[2]) - 1;
    const int k0 = int(std::clamp(std::ceil((z0 - grid.origin[2]) / grid.spacing[2]), 0.0, last_k + 1));
    const int k1 = int(std::clamp(std::floor((z1 - grid.origin[2]) / grid.spacing[2]), -1.0, last_k));
    auto point = std::lower_bound(points.begin(), points.end(), GridPoint{i, j, k0});
    for (; point != points.end() && *point <= GridPoint{i, j, k1}; ++point)
      inside[std::size_t(point - points.begin())] = 1;
  });
  return inside;
}

}  // namespace

Solid make_solid(const TriangleMesh& mesh, ClosedSurface surface, double voxel) {
  Solid solid;
  solid.surface = std::move(surface);
  solid.mesh_volume = std::abs(solid.surface.volume);
  solid.area = surface_area(mesh);
  note_faults(solid.surface, solid.notes);

  const double slack = 1e-3 * solid.area * voxel;
  const double winding_volume = inside_volume(solid.surface);
  solid.volume = winding_volume;
  solid.method = "winding numbers";
  if (solid.mesh_volume > 0 && !agree(winding_volume, solid.mesh_volume, slack))
    solid.notes.push_back(
        fmt::format("parts overlap or lie inside one another: they enclose {:.4g} m3 together, {:.4g} m3 one by one",
                    winding_volume, solid.mesh_volume));

  constexpr double max_band_voxels = 3e7;
  const double affordable_voxel = std::sqrt(band_voxels(solid.area, 1) / max_band_voxels);
  const bool affordable = affordable_voxel <= 2 * voxel;
  voxel = std::max(voxel, affordable_voxel);
  if (!affordable || voxel < LevelSetOptions::smallest_voxel) {
    solid.notes.push_back(
        "the cells are too fine for a level set of the whole surface: the inside was found by winding numbers");
    return solid;
  }
  const Vector3d low = mesh.positions.colwise().minCoeff();
  constexpr double merged_share = 1.0 / 16;  // of a voxel
  LevelSet level_set(mesh.positions,
                     is_long_work(mesh, voxel) ? merged_within(mesh, merged_share * voxel) : mesh.triangles, low,
                     {.voxel = voxel});
  solid.level_set_volume = level_set.volume();
  if (trust_level_set(mesh, solid, winding_volume, slack)) {
    solid.method = "level set";
    solid.volume = solid.level_set_volume;
    solid.level_set = std::move(level_set);
  } else {
    solid.notes.push_back(fmt::format(
        "the level set encloses {:.4g} m3 and the surface {:.4g} m3: the inside was found by winding numbers{}",
        solid.level_set_volume, winding_volume, solid.surface.num_holes > 0 ? ", with the holes capped" : ""));
  }
  return solid;
}

std::vector<char> are_inside(const Solid& solid, const PointGrid& grid, const std::vector<GridPoint>& points) {
  return solid.level_set ? inside_by_level_set(*solid.level_set, grid, points)
                         : inside_by_winding(solid.surface, grid, points);
}

}  // namespace umax
