#include "core/contact/obstacle_side.h"

#include <algorithm>
#include <optional>

namespace umax {
namespace {

constexpr int most_strides = 500;
constexpr int halvings = 30;

// where the straight way from X0, which is outside, to X enters the obstacle
std::optional<Vector3d> entry(const ObstacleShape& shape, const Vector3d& X0, const Vector3d& X, double start,
                              double least) {
  const double length = (X - X0).norm();
  const auto at = [&](double along) -> Vector3d { return X0 + along / length * (X - X0); };
  // as far as nothing can be in between, but never less than a little
  double before = 0, distance = start;
  for (int stride = 0; before < length && stride < most_strides; ++stride) {
    double along = std::min(before + std::max(distance, least), length);
    distance = signed_distance(shape, at(along)).distance;
    if (distance > 0) {
      before = along;
      continue;
    }
    for (int i = 0; i < halvings; ++i) {
      const double middle = 0.5 * (before + along);
      (signed_distance(shape, at(middle)).distance > 0 ? before : along) = middle;
    }
    return at(along);
  }
  return std::nullopt;
}

}  // namespace

DistanceSample distance_from_side(const ObstacleShape& shape, const Vector3d& X0, const Vector3d& X, double slack) {
  const DistanceSample nearest = signed_distance(shape, X);
  const Vector3d way = X - X0;
  if (!can_be_passed(shape) || nearest.distance > way.norm()) return nearest;
  if (nearest.distance > 0 && way.dot(nearest.gradient) <= 0) return nearest;  // it comes nearer
  const DistanceSample start = signed_distance(shape, X0);
  if (start.distance < -slack) return nearest;
  if (nearest.distance > 0 && nearest.distance + start.distance > way.norm()) return nearest;
  std::optional<Vector3d> entered;
  if (start.distance <= 0 && way.dot(start.gradient) < 0)
    entered = X0;
  else
    entered = entry(shape, X0, X, start.distance, slack);
  if (!entered) return nearest;
  const Vector3d normal = *entered == X0 ? start.gradient : signed_distance(shape, *entered).gradient;
  if (normal.dot(nearest.gradient) >= 0) return nearest;
  return {normal.dot(X - *entered), normal};
}

}  // namespace umax
