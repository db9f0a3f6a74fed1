#include "embedding/surface/winding_sides.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace umax {
namespace {

constexpr double same_place = 1e-7;       // [-] of the largest extent
constexpr int most_columns = 2048;        // along an axis
constexpr int entries_per_triangle = 32;  // on average, at most

using Corners = std::array<Vector3d, 3>;

// where an edge passes the line of that v; the same bits from both of its triangles
double crossing(Eigen::Vector2d a, Eigen::Vector2d b, double v) {
  if (std::tie(b[0], b[1]) < std::tie(a[0], a[1])) std::swap(a, b);
  return a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
}

// How often a triangle's border runs around a point: -1, 0 or 1. Half-open: a point on an edge or a corner belongs to
// one of the triangles around it.
int turns_around(const std::array<Eigen::Vector2d, 3>& corners, const Eigen::Vector2d& point) {
  int turns = 0;
  for (std::size_t side = 0; side < 3; ++side) {
    const Eigen::Vector2d &a = corners[side], &b = corners[(side + 1) % 3];
    if ((a[1] <= point[1]) == (b[1] <= point[1])) continue;
    if (crossing(a, b, point[1]) > point[0]) turns += a[1] <= point[1] ? 1 : -1;
  }
  return turns;
}

Vector3d area_normal(const Corners& corners) {
  return (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

// how high the triangle's plane is along an axis above (u, v), within the triangle's own range
double height_at(const Corners& corners, const Vector3d& point, int u, int v, int axis) {
  const Vector3d normal = area_normal(corners), way = point - corners[0];
  const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
  const double height = corners[0][axis] - (way[u] * normal[u] + way[v] * normal[v]) / normal[axis];
  return std::isfinite(height) ? std::clamp(height, low, high) : 0.5 * (low + high);
}

Corners corners_of(const Points& positions, const Triangles& triangles, int t) {
  return {positions.row(triangles(t, 0)), positions.row(triangles(t, 1)), positions.row(triangles(t, 2))};
}

}  // namespace

SideFinder::SideFinder(const Points& positions, const Triangles& triangles)
    : positions_(positions), triangles_(triangles) {
  if (triangles.rows() == 0) return;
  Eigen::AlignedBox3d box;
  for (const int corner : triangles.reshaped()) box.extend(positions.row(corner).transpose());
  low_ = box.min();
  extent_ = box.sizes();
  for (int axis = 0; axis < 3; ++axis) columns_[std::size_t(axis)] = make_columns(axis);
}

int SideFinder::Columns::cell_along(int side, double coordinate) const {
  return std::clamp(int((coordinate - origin[side]) / spacing[side]), 0, size - 1);
}

template <class Visit>
void SideFinder::for_each_cell(const Columns& columns, int triangle, const Visit& visit) const {
  const Corners corners = corners_of(positions_, triangles_, triangle);
  const Vector3d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Vector3d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  const int last_i = columns.cell_along(0, high[columns.u]), last_j = columns.cell_along(1, high[columns.v]);
  for (int i = columns.cell_along(0, low[columns.u]); i <= last_i; ++i)
    for (int j = columns.cell_along(1, low[columns.v]); j <= last_j; ++j) visit(i * columns.size + j);
}

long long SideFinder::count_entries(const Columns& columns) const {
  long long count = 0;
  for (int t = 0; t < int(triangles_.rows()); ++t) {
    const Corners c = corners_of(positions_, triangles_, t);
    const auto cells = [&](int side, int axis) {
      const auto [low, high] = std::minmax({c[0][axis], c[1][axis], c[2][axis]});
      return columns.cell_along(side, high) - columns.cell_along(side, low) + 1LL;
    };
    count += cells(0, columns.u) * cells(1, columns.v);
  }
  return count;
}

SideFinder::Columns SideFinder::make_columns(int axis) const {
  Columns columns{.u = (axis + 1) % 3, .v = (axis + 2) % 3, .axis = axis, .starts = {}, .triangles = {}};
  columns.origin = {low_[columns.u], low_[columns.v]};
  const auto resize = [&](int size) {
    columns.size = size;
    for (int side = 0; side < 2; ++side) {
      const double extent = extent_[side == 0 ? columns.u : columns.v];
      columns.spacing[side] = extent > 0 ? extent / size : 1;
    }
  };
  resize(std::clamp(int(std::sqrt(double(triangles_.rows()))), 1, most_columns));
  while (columns.size > 1 && count_entries(columns) > entries_per_triangle * triangles_.rows())
    resize(columns.size / 2);

  columns.starts.assign(std::size_t(columns.size) * columns.size + 1, 0);
  for (int t = 0; t < int(triangles_.rows()); ++t) for_each_cell(columns, t, [&](int c) { ++columns.starts[c + 1]; });
  for (std::size_t c = 1; c < columns.starts.size(); ++c) columns.starts[c] += columns.starts[c - 1];
  columns.triangles.resize(std::size_t(columns.starts.back()));
  std::vector<int> next(columns.starts.begin(), columns.starts.end() - 1);
  for (int t = 0; t < int(triangles_.rows()); ++t)
    for_each_cell(columns, t, [&](int c) { columns.triangles[next[c]++] = t; });
  return columns;
}

WindingSides SideFinder::sides_at(int triangle, const Vector3d& point) const {
  const Vector3d normal = area_normal(corners_of(positions_, triangles_, triangle));
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const Columns& columns = columns_[std::size_t(axis)];
  const bool faces_up = normal[axis] > 0;
  const int cell = columns.cell_along(0, point[columns.u]) * columns.size + columns.cell_along(1, point[columns.v]);
  const double touching = same_place * extent_.maxCoeff();
  int below = 0, change = faces_up ? -1 : 1;  // on the way up: through what lies below, and through what lies here
  for (int i = columns.starts[cell]; i < columns.starts[cell + 1]; ++i) {
    const int other = columns.triangles[i];
    if (other == triangle) continue;
    const Corners corners = corners_of(positions_, triangles_, other);
    if (std::min({corners[0][axis], corners[1][axis], corners[2][axis]}) > point[axis] + touching) continue;
    const auto flat = [&](const Vector3d& p) { return Eigen::Vector2d(p[columns.u], p[columns.v]); };
    const int turns = turns_around({flat(corners[0]), flat(corners[1]), flat(corners[2])}, flat(point));
    if (turns == 0) continue;
    const double height = height_at(corners, point, columns.u, columns.v, columns.axis);
    if (height < point[axis] - touching)
      below -= turns;
    else if (height <= point[axis] + touching)
      change -= turns;
  }
  return faces_up ? WindingSides{below, below + change} : WindingSides{below + change, below};
}

}  // namespace umax
