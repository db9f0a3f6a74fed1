#include "tests/support/triangle_measures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace umax::test {
namespace {

double squared_distance(const Vector3d& x, const Vector3d& p, const Vector3d& q) {
  const Vector3d edge = q - p;
  const double length2 = edge.squaredNorm();
  const double share = length2 > 0 ? std::clamp(edge.dot(x - p) / length2, 0.0, 1.0) : 0;
  return (p + share * edge - x).squaredNorm();
}

}  // namespace

double solid_angle(const Triangle& triangle, const Vector3d& x) {
  const Vector3d a = triangle.a - x, b = triangle.b - x, c = triangle.c - x;
  const double na = a.norm(), nb = b.norm(), nc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb);
}

double squared_distance(const Triangle& triangle, const Vector3d& x) {
  const auto& [a, b, c] = triangle;
  const Vector3d normal = (b - a).cross(c - a);
  const bool is_above = normal.squaredNorm() > 0 && normal.cross(b - a).dot(x - a) >= 0 &&
                        normal.cross(c - b).dot(x - b) >= 0 && normal.cross(a - c).dot(x - c) >= 0;
  if (is_above) {
    const double height = normal.dot(x - a);
    return height * height / normal.squaredNorm();
  }
  return std::min({squared_distance(x, a, b), squared_distance(x, b, c), squared_distance(x, c, a)});
}

std::optional<double> crossing(const Vector3d& p, const Vector3d& q, const Triangle& triangle) {
  // its ends lie on the two sides of the plane
  const Vector3d normal = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
  const double side_p = normal.dot(p - triangle.a), side_q = normal.dot(q - triangle.a);
  if (!((side_p < 0 && side_q > 0) || (side_p > 0 && side_q < 0))) return {};

  // its line passes all edges on the same side; a neighbour computes the same number for a shared edge, negated
  const Vector3d a = triangle.a - p, b = triangle.b - p, c = triangle.c - p, along = q - p;
  const double ab = along.dot(a.cross(b)), bc = along.dot(b.cross(c)), ca = along.dot(c.cross(a));
  const bool passes = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  if (!passes) return {};
  return side_p / (side_p - side_q);
}

}  // namespace umax::test
