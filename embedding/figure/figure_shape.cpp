#include "embedding/figure/figure_shape.h"

#include <cmath>

namespace umax::figure {

double distance_to(const RoundCone& cone, const Vector3d& p) {
  const Vector3d axis = cone.b - cone.a, from_a = p - cone.a;
  const double length2 = axis.squaredNorm(), shrink = cone.radius_a - cone.radius_b;
  const double slant2 = length2 - shrink * shrink;
  const double along = from_a.dot(axis), beyond = along - length2;
  const double across2 = (from_a * length2 - axis * along).squaredNorm();
  const double along2 = along * along * length2, beyond2 = beyond * beyond * length2;
  const double side = std::copysign(shrink * shrink * across2, shrink);
  if (std::copysign(slant2 * beyond2, beyond) > side) return std::sqrt(across2 + beyond2) / length2 - cone.radius_b;
  if (std::copysign(slant2 * along2, along) < side) return std::sqrt(across2 + along2) / length2 - cone.radius_a;
  return (std::sqrt(across2 * slant2 / length2) + along * shrink) / length2 - cone.radius_a;
}

double distance_to(const Ellipsoid& ellipsoid, const Vector3d& p) {
  const Eigen::Array3d scaled = (ellipsoid.axes * (p - ellipsoid.centre)).array() / ellipsoid.radii.array();
  const double level = scaled.matrix().norm();
  const double slope = (scaled / ellipsoid.radii.array()).matrix().norm();
  if (slope < 1e-9) return -ellipsoid.radii.minCoeff();
  return level * (level - 1) / slope;
}

}  // namespace umax::figure
