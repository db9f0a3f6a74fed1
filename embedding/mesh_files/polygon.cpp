#include "embedding/mesh_files/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace umax {
namespace {

using Vector2d = Eigen::Vector2d;

/// Twice the signed area of a triangle in the plane.
double area2(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// The corners in a plane across their mean normal (Newell), counter-clockwise.
std::vector<Vector2d> flattened(const Points& positions, const std::vector<int>& corners) {
  const auto point = [&](std::size_t i) -> Vector3d {
    return positions.row(corners[i % corners.size()]) - positions.row(corners[0]);
  };
  Vector3d normal(0, 0, 0);
  for (std::size_t i = 0; i < corners.size(); ++i) normal += point(i).cross(point(i + 1));
  int least = 0;
  normal.cwiseAbs().minCoeff(&least);
  const Vector3d u = normal.cross(Vector3d::Unit(least)).normalized(), v = normal.normalized().cross(u);
  std::vector<Vector2d> flat;
  for (std::size_t i = 0; i < corners.size(); ++i) flat.emplace_back(u.dot(point(i)), v.dot(point(i)));
  return flat;
}

/// Whether the corner at `at` of those left can be cut off: it is convex and no other lies in its triangle.
bool is_ear(const std::vector<Vector2d>& flat, const std::vector<int>& left, std::size_t at) {
  const std::size_t n = left.size();
  const int before = left[(at + n - 1) % n], here = left[at], after = left[(at + 1) % n];
  const Vector2d &a = flat[std::size_t(before)], &b = flat[std::size_t(here)], &c = flat[std::size_t(after)];
  if (!(area2(a, b, c) > 0)) return false;
  return std::none_of(left.begin(), left.end(), [&](int other) {
    if (other == before || other == here || other == after) return false;
    const Vector2d& p = flat[std::size_t(other)];
    return area2(a, b, p) >= 0 && area2(b, c, p) >= 0 && area2(c, a, p) >= 0;
  });
}

}  // namespace

void cut_polygon(const Points& positions, const std::vector<int>& corners, std::vector<std::array<int, 3>>& triangles) {
  constexpr std::size_t most_looked_at = 1000;  // corners: more are cut as a fan, as looking at all pairs takes long
  std::vector<int> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  if (left.size() > 3 && left.size() <= most_looked_at) {
    const std::vector<Vector2d> flat = flattened(positions, corners);
    for (std::size_t at = 1; left.size() > 3 && at <= left.size();) {
      const std::size_t n = left.size(), here = at % n;
      if (!is_ear(flat, left, here)) {
        ++at;
        continue;
      }
      triangles.push_back({left[(here + n - 1) % n], left[here], left[(here + 1) % n]});
      left.erase(left.begin() + std::ptrdiff_t(here));
      at = 1;
    }
  }
  for (std::size_t k = 2; k < left.size(); ++k) triangles.push_back({left[0], left[k - 1], left[k]});
}

}  // namespace umax
