#include "embedding/surface/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace umax {
namespace {

constexpr double rounding = 1e-9;      // of a length: as many points as without it
constexpr double clearly_sharp = 0.5;  // [-] of |n1 - n2|, 29 degrees: of ridges that are told from bending
constexpr double fine_share = 0.5;     // of the spacing: a surface that is so fine gets no points

int intervals(double length, double spacing) {
  return std::max(1, int(std::ceil(length / spacing * (1 - rounding))));
}

double length_of(const RestSurface& surface, int t, int k) {
  return (corner_of(surface, t, (k + 1) % 3) - corner_of(surface, t, k)).norm();
}

// [cells]
double cells_along(const RestSurface& surface, int t, int k, const SurfaceSampling& sampling) {
  return (sampling.to_cells * (corner_of(surface, t, (k + 1) % 3) - corner_of(surface, t, k))).norm();
}

bool is_large(const RestSurface& surface, int t, const SurfaceSampling& sampling) {
  double longest = 0;
  for (int k = 0; k < 3; ++k) longest = std::max(longest, cells_along(surface, t, k, sampling));
  return longest > sampling.spacing * (1 + rounding);
}

// [m]
double spacing_along_ridge(double sharpness, const SurfaceSampling& sampling) {
  return 4 * sampling.ridge_depth / std::max(sharpness, 1e-300);
}

// Is an edge between small triangles sharp and longer than its spacing, be it of a ridge or a groove?
bool is_long_and_sharp(const RestSurface& surface, int t, int k, const SurfaceSampling& sampling) {
  const double half_cosine = surface.triangle_normals.row(t).dot(surface.edge_normals.row(3 * t + k));
  const double sharpness = 2 * std::sqrt(std::max(0.0, 1 - half_cosine * half_cosine));
  const double cells = cells_along(surface, t, k, sampling);
  return sharpness > clearly_sharp && cells > fine_share * sampling.spacing &&
         (cells > sampling.spacing || length_of(surface, t, k) > spacing_along_ridge(sharpness, sampling));
}

using EdgeKey = std::array<int, 2>;  // its vertices, ascending
struct EdgeSide {
  int triangle = 0, third = 0;  // and its third corner
};
using EdgeSides = std::vector<EdgeSide>;

EdgeKey edge_of(const RestSurface& surface, int t, int k) {
  const auto [low, high] = std::minmax(surface.triangles(t, k), surface.triangles(t, (k + 1) % 3));
  return {low, high};
}

// the edges of large triangles, and other long ones that are sharp, with all triangles that they border
std::map<EdgeKey, EdgeSides> edges_of(const RestSurface& surface, const std::vector<char>& large,
                                      const SurfaceSampling& sampling) {
  std::map<EdgeKey, EdgeSides> edges;
  std::vector<char> is_end(std::size_t(surface.vertices.rows()), 0);
  const auto for_each = [&](const auto& visit) {
    for (int t = 0; t < int(surface.triangles.rows()); ++t)
      for (int k = 0; k < 3; ++k) visit(t, k, edge_of(surface, t, k));
  };
  for_each([&](int t, int k, const EdgeKey& key) {
    if (!large[std::size_t(t)] && !is_long_and_sharp(surface, t, k, sampling)) return;
    edges.try_emplace(key);
    for (const int end : key) is_end[std::size_t(end)] = 1;
  });
  for_each([&](int t, int k, const EdgeKey& key) {
    if (!is_end[std::size_t(key[0])] || !is_end[std::size_t(key[1])]) return;
    const auto edge = edges.find(key);
    if (edge != edges.end()) edge->second.push_back({t, surface.triangles(t, (k + 2) % 3)});
  });
  return edges;
}

// |n1 - n2| of a ridge, 0 of a groove; of a border, or where more than two triangles meet, as of the sharpest ridge
double sharpness(const RestSurface& surface, const EdgeKey& key, const EdgeSides& sides) {
  if (sides.size() != 2) return 2;
  const EdgeSide &one = sides[0], &other = sides[1];
  const Eigen::RowVector3d away = surface.vertices.row(other.third) - surface.vertices.row(key[0]);
  if (surface.triangle_normals.row(one.triangle).dot(away) >= 0) return 0;
  return (surface.triangle_normals.row(one.triangle) - surface.triangle_normals.row(other.triangle)).norm();
}

// inner points of so many equal parts
void add_along(const Vector3d& from, const Vector3d& to, int parts, std::vector<Vector3d>& points) {
  for (int i = 1; i < parts; ++i) points.emplace_back(from + double(i) / parts * (to - from));
}

void add_along_edge(const RestSurface& surface, const EdgeKey& edge, const EdgeSides& sides,
                    const SurfaceSampling& sampling, std::vector<Vector3d>& points) {
  const Vector3d from = surface.vertices.row(edge[0]), to = surface.vertices.row(edge[1]);
  const double of_ridge = spacing_along_ridge(sharpness(surface, edge, sides), sampling);
  add_along(from, to,
            std::max(intervals((sampling.to_cells * (to - from)).norm(), sampling.spacing),
                     intervals((to - from).norm(), of_ridge)),
            points);
}

// rows of points along the edge that is longest in cells, as far apart as in a lattice of equal triangles of cells
void add_within(const RestSurface& surface, int t, const SurfaceSampling& sampling, std::vector<Vector3d>& points) {
  int longest = 0;
  for (int k = 1; k < 3; ++k)
    if (cells_along(surface, t, k, sampling) > cells_along(surface, t, longest, sampling)) longest = k;
  const Vector3d a = corner_of(surface, t, longest), b = corner_of(surface, t, (longest + 1) % 3),
                 apex = corner_of(surface, t, (longest + 2) % 3);
  const Vector3d base = sampling.to_cells * (b - a), side = sampling.to_cells * (apex - a);  // [cells]
  const int rows = intervals(base.cross(side).norm() / base.norm(), std::sqrt(0.75) * sampling.spacing);
  for (int row = 1; row < rows; ++row) {
    const double share = double(row) / rows;
    add_along(a + share * (apex - a), b + share * (apex - b), intervals((1 - share) * base.norm(), sampling.spacing),
              points);
  }
}

}  // namespace

Points sample_between_vertices(const RestSurface& surface, const SurfaceSampling& sampling) {
  std::vector<char> large(std::size_t(surface.triangles.rows()), 0);
  for (int t = 0; t < int(surface.triangles.rows()); ++t) large[std::size_t(t)] = is_large(surface, t, sampling);
  std::vector<Vector3d> points;
  for (const auto& [key, sides] : edges_of(surface, large, sampling))
    add_along_edge(surface, key, sides, sampling, points);
  std::vector<int> corners;
  for (int t = 0; t < int(surface.triangles.rows()); ++t) {
    if (large[std::size_t(t)]) add_within(surface, t, sampling, points);
    for (int k = 0; k < 3; ++k)
      if (surface.triangles(t, k) >= sampling.num_given) corners.push_back(surface.triangles(t, k));
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  for (const int corner : corners) points.emplace_back(surface.vertices.row(corner).transpose());

  Points all(Eigen::Index(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) all.row(Eigen::Index(i)) = points[i].transpose();
  return all;
}

}  // namespace umax
