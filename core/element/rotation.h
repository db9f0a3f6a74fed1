// Rotations: the one nearest to a 3x3 matrix (its polar factor, proper also for inverted and degenerate input), and
// Euler angles.
#pragma once

#include "core/base/types.h"

namespace umax {

/// The proper rotation R (det = +1) that maximises tr(R^T G); defined, finite and deterministic for every finite G,
/// degenerate and inverted ones included.
Matrix3d polar_rotation(const Matrix3d& G);

/// World rotation for angles in degrees about the world's X, then Y, then Z axis.
Matrix3d rotation_from_degrees(const Vector3d& degrees_xyz);

/// [v]x, so that cross_matrix(v) * w = v x w.
Matrix3d cross_matrix(const Vector3d& v);

}  // namespace umax
