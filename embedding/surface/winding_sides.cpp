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
constexpr double rounding = 1e-9;                   // [-] of it, that the triangles' boxes have to spare
constexpr std::ptrdiff_t few_queries = 16;          // that are not worth a box of their own
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

// whether an edge of the triangle has all of the box beyond it in the plane
bool passes_by(const std::array<Eigen::Vector2d, 3>& corners, const Eigen::AlignedBox2d& box) {
  const Eigen::Vector2d half_size = 0.5 * box.sizes();
  for (std::size_t side = 0; side < 3; ++side) {
    const Eigen::Vector2d edge = corners[(side + 1) % 3] - corners[side], across(-edge[1], edge[0]);
    const double apex = across.dot(corners[(side + 2) % 3] - corners[side]),
                 middle = across.dot(box.center() - corners[side]), reach = across.cwiseAbs().dot(half_size);
    if (middle - reach > std::max(apex, 0.0) || middle + reach < std::min(apex, 0.0)) return true;
  }
  return false;
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
  std::vector<Eigen::Vector2d> points{};     // of the queries
  std::vector<Eigen::AlignedBox2d> boxes{};  // around each triangle, with rounding to spare

  Eigen::Vector2d flat(const Vector3d& p) const { return {p[u], p[v]}; }
  std::array<Eigen::Vector2d, 3> flat(const Corners& corners) const {
    return {flat(corners[0]), flat(corners[1]), flat(corners[2])};
  }
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

// the box with what rounding may take from it
Eigen::AlignedBox2d SideFinder::with_spare(const Eigen::AlignedBox2d& box) const {
  const Eigen::Vector2d spare = Eigen::Vector2d::Constant(rounding * extent_);
  return {box.min() - spare, box.max() + spare};
}

std::vector<WindingSides> SideFinder::sides_at(const std::vector<SideQuery>& queries) const {
  std::vector<WindingSides> sides(queries.size());
  std::array<std::vector<int>, 3> along;
  for (std::size_t q = 0; q < queries.size(); ++q)
    along[steepest_axis(area_normal(corners_of(positions_, triangles_, queries[q].triangle)))].push_back(int(q));
  for (int axis = 0; axis < 3; ++axis) {
    Search search{axis, (axis + 1) % 3, (axis + 2) % 3, queries, sides};
    for (const SideQuery& query : queries) search.points.push_back(search.flat(query.point));
    search.boxes.resize(std::size_t(triangles_.rows()));
    for (const int t : counting_) {
      Eigen::AlignedBox2d& box = search.boxes[std::size_t(t)];
      for (const Eigen::Vector2d& corner : search.flat(corners_of(positions_, triangles_, t))) box.extend(corner);
      box = with_spare(box);
    }
    descend(search, along[axis].begin(), along[axis].end(), counting_);
  }
  return sides;
}

// Halves the queries until they are few, each time with the triangles that lie above or below their box.
void SideFinder::descend(const Search& search, std::vector<int>::iterator first, std::vector<int>::iterator last,
                         const std::vector<int>& triangles) const {
  if (last - first <= few_queries || triangles.size() <= few_triangles) {
    for (auto q = first; q != last; ++q) search.sides[*q] = sides_at(search, search.queries[*q], triangles);
    return;
  }
  const auto box_of = [&](auto begin, auto end) {
    Eigen::AlignedBox2d box;
    for (auto q = begin; q != end; ++q) box.extend(search.points[std::size_t(*q)]);
    return box;
  };
  const Eigen::Vector2d sizes = box_of(first, last).sizes();
  const int across = sizes[0] >= sizes[1] ? 0 : 1;
  const auto middle = first + (last - first) / 2;
  std::nth_element(first, middle, last, [&](int a, int b) {
    return std::pair(search.points[std::size_t(a)][across], a) < std::pair(search.points[std::size_t(b)][across], b);
  });
  const std::array<Eigen::AlignedBox2d, 2> halves{box_of(first, middle), box_of(middle, last)};
  std::array<std::vector<int>, 2> met;
  for (const int t : triangles) {
    const Eigen::AlignedBox2d& box = search.boxes[std::size_t(t)];
    for (const std::size_t half : {0, 1}) {
      if (!box.intersects(halves[half])) continue;
      // a triangle's own box tells enough where it is small
      const bool is_small = (box.sizes().array() <= halves[half].sizes().array()).all();
      if (is_small || !passes_by(search.flat(corners_of(positions_, triangles_, t)), with_spare(halves[half])))
        met[half].push_back(t);
    }
  }
  if (last - first < worth_a_thread) {
    descend(search, first, middle, met[0]);
    descend(search, middle, last, met[1]);
  } else {
    tbb::parallel_invoke([&] { descend(search, first, middle, met[0]); },
                         [&] { descend(search, middle, last, met[1]); });
  }
}

WindingSides SideFinder::sides_at(const Search& search, const SideQuery& query,
                                  const std::vector<int>& triangles) const {
  const int axis = search.axis, own = first_copy_[query.triangle];
  const Vector3d& point = query.point;
  const Eigen::Vector2d flat_point = search.flat(point);
  const auto turns_of = [&](const Corners& corners) { return turns_around(search.flat(corners), flat_point); };
  const bool faces_up = area_normal(corners_of(positions_, triangles_, query.triangle))[axis] > 0;
  const double touching = same_place * extent_;
  int below = 0, change = faces_up ? -1 : 1;  // on the way up: through what lies below, and through what lies here
  if (const int copies = times_[own] - direction_[query.triangle]; copies != 0)
    change -= copies * turns_of(corners_of(positions_, triangles_, own));
  for (const int other : triangles) {
    if (other == own || !search.boxes[std::size_t(other)].contains(flat_point)) continue;
    const Corners corners = corners_of(positions_, triangles_, other);
    if (std::min({corners[0][axis], corners[1][axis], corners[2][axis]}) > point[axis] + touching) continue;
    const int turns = times_[other] * turns_of(corners);
    if (turns == 0) continue;
    const double height = height_at(corners, point, search.u, search.v, axis);
    if (height < point[axis] - touching)
      below -= turns;
    else if (height <= point[axis] + touching)
      change -= turns;
  }
  return faces_up ? WindingSides{below, below + change} : WindingSides{below + change, below};
}

}  // namespace umax
