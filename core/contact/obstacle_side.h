// The side of an obstacle on which a point belongs. The nearest side is the wrong one for a point that has come through
// a thin wall, or through most of it.
//
// gap = n . (X - E),  normal n = grad phi(E),  where the nearest side does not face the way that the point came by:
//       n . grad phi(X) < 0
//
// X0, X: the point at the step's start and now, as the obstacle sees it [m]
// E: where the way from X0 to X enters the obstacle;  phi: signed distance from it [m]
#pragma once

#include "core/model/obstacle.h"

namespace umax {

/// signed_distance() at X, or the gap and normal above. slack: [m] by which X0 may be inside and count as outside; a
/// point that was deeper inside leaves by the nearest way. Walls thinner than the slack may be missed by ways that graze.
DistanceSample distance_from_side(const ObstacleShape& shape, const Vector3d& X0, const Vector3d& X, double slack);

/// Has the obstacle sides that a way can lead through?
inline bool can_be_passed(const ObstacleShape& shape) {
  return !std::holds_alternative<HalfSpace>(shape);
}

}  // namespace umax
