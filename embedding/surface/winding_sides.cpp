#include "embedding/surface/winding_sides.h"

#include <tbb/parallel_invoke.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace umax {
namespace {

constexpr double same_place = 1e-7;                 // [-] of the largest extent
constexpr double rounding = 1e-9;                   // [-] of it, that boxes have to spare
constexpr std::ptrdiff_t few_queries = 8;           // that are not worth a box of their own
constexpr std::size_t few_triangles = 16;           // likewise
constexpr std::ptrdiff_t worth_a_thread = 1 << 12;  // [queries]

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

int steepest_axis(const Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return int(axis);
}

// whether a triangle and a box meet in the plane, for all that rounding says
bool may_meet(const std::array<Eigen::Vector2d, 3>& corners, const Eigen::AlignedBox2d& box) {
  Eigen::AlignedBox2d around(corners[0]);
  around.extend(corners[1]).extend(corners[2]);
  if (!around.intersects(box)) return false;
  const Eigen::Vector2d half_size = 0.5 * box.sizes();
  for (std::size_t side = 0; side < 3; ++side) {
    const Eigen::Vector2d edge = corners[(side + 1) % 3] - corners[side], across(-edge[1], edge[0]);
    const double apex = across.dot(corners[(side + 2) % 3] - corners[side]),
                 middle = across.dot(box.center() - corners[side]), reach = across.cwiseAbs().dot(half_size);
    if (middle - reach > std::max(apex, 0.0) || middle + reach < std::min(apex, 0.0)) return false;
  }
  return true;
}

struct Sorted {
  std::array<int, 3> corners;
  int direction = 1;  // -1: an odd number of swaps away
};
Sorted sorted_corners(const Triangles& triangles, int t) {
  Sorted sorted{{triangles(t, 0), triangles(t, 1), triangles(t, 2)}};
  for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
    if (sorted.corners[a] > sorted.corners[b]) {
      std::swap(sorted.corners[a], sorted.corners[b]);
      sorted.direction = -sorted.direction;
    }
  return sorted;
}

}  // namespace

// what the queries along one axis have in common
struct SideFinder::Search {
  int axis, u, v;
  const std::vector<SideQuery>& queries;
  std::vector<WindingSides>& sides;

  Eigen::Vector2d flat(const Vector3d& p) const { return {p[u], p[v]}; }
};

SideFinder::SideFinder(const Points& positions, const Triangles& triangles)
    : positions_(positions), triangles_(triangles) {
  Eigen::AlignedBox3d box;
  for (const int corner : triangles.reshaped()) box.extend(positions.row(corner).transpose());
  if (!box.isEmpty()) extent_ = box.sizes().maxCoeff();
  find_copies();
}

void SideFinder::find_copies() {
  const auto count = std::size_t(triangles_.rows());
  std::vector<Sorted> sorted(count);
  for (std::size_t t = 0; t < count; ++t) sorted[t] = sorted_corners(triangles_, int(t));
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::tie(sorted[a].corners, a) < std::tie(sorted[b].corners, b); });
  first_copy_.resize(count);
  direction_.resize(count);
  times_.assign(count, 0);
  for (std::size_t i = 0, first = 0; i < count; ++i) {
    const int t = order[i];
    if (sorted[order[first]].corners != sorted[t].corners) first = i;
    first_copy_[t] = order[first];
    direction_[t] = sorted[t].direction * sorted[order[first]].direction;
    times_[order[first]] += direction_[t];
  }
  for (std::size_t t = 0; t < count; ++t)
    if (times_[t] != 0) counting_.push_back(int(t));
}

std::vector<WindingSides> SideFinder::sides_at(const std::vector<SideQuery>& queries) const {
  std::vector<WindingSides> sides(queries.size());
  std::array<std::vector<int>, 3> along;
  for (std::size_t q = 0; q < queries.size(); ++q)
    along[steepest_axis(area_normal(corners_of(positions_, triangles_, queries[q].triangle)))].push_back(int(q));
  for (int axis = 0; axis < 3; ++axis)
    descend({axis, (axis + 1) % 3, (axis + 2) % 3, queries, sides}, along[axis].begin(), along[axis].end(), counting_);
  return sides;
}

// Halves the queries until they are few, each time with the triangles that lie above or below their box.
void SideFinder::descend(const Search& search, std::vector<int>::iterator first, std::vector<int>::iterator last,
                         const std::vector<int>& triangles) const {
  if (last - first <= few_queries || triangles.size() <= few_triangles) {
    for (auto q = first; q != last; ++q) search.sides[*q] = sides_at(search.queries[*q], search.axis, triangles);
    return;
  }
  const auto box_of = [&](auto begin, auto end) {
    Eigen::AlignedBox2d box;
    for (auto q = begin; q != end; ++q) box.extend(search.flat(search.queries[*q].point));
    return box;
  };
  const Eigen::Vector2d sizes = box_of(first, last).sizes();
  const int across = sizes[0] >= sizes[1] ? search.u : search.v;
  const auto middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [&](int a, int b) {
    return std::pair(search.queries[a].point[across], a) < std::pair(search.queries[b].point[across], b);
  });
  const auto descend_half = [&](auto begin, auto end) {
    Eigen::AlignedBox2d box = box_of(begin, end);
    const Eigen::Vector2d spare = Eigen::Vector2d::Constant(rounding * extent_);
    box.min() -= spare;
    box.max() += spare;
    std::vector<int> met;
    for (const int t : triangles) {
      const Corners corners = corners_of(positions_, triangles_, t);
      if (may_meet({search.flat(corners[0]), search.flat(corners[1]), search.flat(corners[2])}, box)) met.push_back(t);
    }
    descend(search, begin, end, met);
  };
  if (last - first < worth_a_thread) {
    descend_half(first, middle);
    descend_half(middle, last);
  } else {
    tbb::parallel_invoke([&] { descend_half(first, middle); }, [&] { descend_half(middle, last); });
  }
}

WindingSides SideFinder::sides_at(const SideQuery& query, int axis, const std::vector<int>& triangles) const {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3, own = first_copy_[query.triangle];
  const Vector3d& point = query.point;
  const auto flat = [&](const Vector3d& p) { return Eigen::Vector2d(p[u], p[v]); };
  const auto turns_of = [&](const Corners& corners) {
    return turns_around({flat(corners[0]), flat(corners[1]), flat(corners[2])}, flat(point));
  };
  const bool faces_up = area_normal(corners_of(positions_, triangles_, query.triangle))[axis] > 0;
  const double touching = same_place * extent_;
  int below = 0, change = faces_up ? -1 : 1;  // on the way up: through what lies below, and through what lies here
  if (const int copies = times_[own] - direction_[query.triangle]; copies != 0)
    change -= copies * turns_of(corners_of(positions_, triangles_, own));
  for (const int other : triangles) {
    if (other == own) continue;
    const Corners corners = corners_of(positions_, triangles_, other);
    if (std::min({corners[0][axis], corners[1][axis], corners[2][axis]}) > point[axis] + touching) continue;
    const int turns = times_[other] * turns_of(corners);
    if (turns == 0) continue;
    const double height = height_at(corners, point, u, v, axis);
    if (height < point[axis] - touching)
      below -= turns;
    else if (height <= point[axis] + touching)
      change -= turns;
  }
  return faces_up ? WindingSides{below, below + change} : WindingSides{below + change, below};
}

}  // namespace umax
