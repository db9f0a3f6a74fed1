#include "embedding/surface/triangle_box.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace umax {
namespace {

bool separates(const Vector3d& axis, const std::array<Vector3d, 3>& corners, const Vector3d& half_size) {
  const double a = axis.dot(corners[0]), b = axis.dot(corners[1]), c = axis.dot(corners[2]);
  const double radius = axis.cwiseAbs().dot(half_size);
  return std::min({a, b, c}) > radius || std::max({a, b, c}) < -radius;
}

}  // namespace

bool triangle_meets_box(const std::array<Vector3d, 3>& corners, const Vector3d& half_size) {
  for (int axis = 0; axis < 3; ++axis)
    if (separates(Vector3d::Unit(axis), corners, half_size)) return false;
  const std::array<Vector3d, 3> edges{corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  const Vector3d normal = edges[0].cross(edges[1]);
  if (std::abs(normal.dot(corners[0])) > normal.cwiseAbs().dot(half_size)) return false;
  for (const Vector3d& edge : edges)
    for (int axis = 0; axis < 3; ++axis)
      if (separates(Vector3d::Unit(axis).cross(edge), corners, half_size)) return false;
  return true;
}

}  // namespace umax
