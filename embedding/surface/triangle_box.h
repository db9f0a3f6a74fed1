// Whether a triangle meets an axis-aligned box, by separating axes: 3 of the box, 1 of the triangle, 9 of pairs of
// edges.
#pragma once

#include <array>

#include "core/base/types.h"

namespace umax {

/// corners: relative to the box's centre. Touching counts as meeting. A triangle without area is tested as its segment,
/// which may answer yes for a box that is only near.
bool triangle_meets_box(const std::array<Vector3d, 3>& corners, const Vector3d& half_size);

}  // namespace umax
