// Where the camera stands when the scene does not say: so that a box around the whole motion fills the picture.
#pragma once

#include <Eigen/Geometry>

#include "scenes/scene.h"

namespace umax {

using Box = Eigen::AlignedBox3d;  // [m]

/// The scene's camera at a time [s]; position and target that are unset are chosen so that the box fits into a picture with
/// this aspect (width / height) at time 0, seen from the front, a little from the right and from above.
Camera frame_camera(const CameraDescription& description, const Box& box, double aspect, double time = 0);

/// A camera, as at time 0, in the direction `back` (unit, from the target) whose picture the points #P x 3 [m] fill.
Camera frame_points(const CameraDescription& description, const Points& points, double aspect, const Vector3d& back);

/// A camera, as at time 0, that has gone `turn` in [0, 1) of a circle around the box, starting from the front.
Camera turntable_camera(const CameraDescription& description, const Box& box, double aspect, double turn);

}  // namespace umax
