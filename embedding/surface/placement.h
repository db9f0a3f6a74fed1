// How a mesh is put into the scene: unit, upward axis, scale, rotation and position.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "core/base/triangle_mesh.h"

namespace umax {

struct Placement {
  std::optional<double> unit = std::nullopt;        // [m] length of one file unit; unset: 1
  std::optional<std::string> up = std::nullopt;     // "x", "y", "z" or with a sign, "-z"; unset: "y"
  std::optional<double> height = std::nullopt;      // [m] the placed bounding box is this tall
  std::optional<double> scale = std::nullopt;       // [-] uniform; ignored when height is given
  Vector3d rotation_degrees{0, 0, 0};               // about world X, then Y, then Z
  std::optional<Vector3d> position = std::nullopt;  // [m] where the centre of the bounding box goes; unset: where it is
};

/// Where the mesh has gone.
struct Placed {
  Eigen::Affine3d placed_from_own = Eigen::Affine3d::Identity();  // of points in the mesh's own units and axes
  double scale = 1;                                               // [m] of one of its units
};

/// Applies, in this order: unit, up axis to +Y, rotation, height or scale (about the world's origin), position. Turns
/// normals along. Throws Error (bad_data) for values that are not positive, an unknown axis, or a height for a mesh
/// that is flat. riders, when given, move along: points in the mesh's own units and axes.
Placed place(TriangleMesh& mesh, const Placement& placement, Points* riders = nullptr);

}  // namespace umax
