// Where the camera stands when the scene does not say: so that a box around the whole motion fills the picture.
#pragma once

#include <Eigen/Geometry>

#include "scenes/scene.h"

namespace umax {

using Box = Eigen::AlignedBox3d;  // [m]

/// How far points reach towards the four sides of a picture and in depth, for a camera that sees them from the front, a
/// little from the right and from above: all that it takes to frame them without waste. Points may come one by one.
struct ViewFit {
  double aspect = 1, vertical_fov_degrees = 35;                                     // of the picture that it is for
  double right = -infinite, left = -infinite, top = -infinite, bottom = -infinite;  // [m] beyond the sides' planes
  double near = -infinite, far = infinite;                                          // [m] towards the camera
  static constexpr double infinite = 1e300;

  void extend(const Points& points);  // #P x 3 [m]
  bool is_empty() const { return near < far; }
  /// Whether it is for the pictures that such a camera takes.
  bool fits(const CameraDescription& description, double picture_aspect) const;
};
ViewFit view_fit(const CameraDescription& description, double aspect);

/// The scene's camera at a time [s]; position and target are unset, and chosen so that the points of the fit just fill
/// the picture.
Camera frame_camera(const CameraDescription& description, const ViewFit& fit, double time = 0);

/// Whether the scene leaves it to us where the camera stands.
inline bool is_framed(const CameraDescription& description) {
  return !description.motion && !description.position && !description.target;
}

/// The scene's camera at a time [s]; position and target that are unset are chosen so that the box fits into a picture with
/// this aspect (width / height) at time 0, seen from the front, a little from the right and from above.
Camera frame_camera(const CameraDescription& description, const Box& box, double aspect, double time = 0);

/// A camera, as at time 0, in the direction `back` (unit, from the target) whose picture the points #P x 3 [m] fill.
Camera frame_points(const CameraDescription& description, const Points& points, double aspect, const Vector3d& back);

/// The circle of a camera, whose height and width are chosen so that points #P x 3 [m] just fill the picture on the way.
struct TurntableFit {
  Vector3d center{0, 0, 0};         // [m] what it goes round
  double distance = 1, height = 0;  // [m] along and across its view
};
TurntableFit turntable_fit(const CameraDescription& description, const Points& points, double aspect);

/// That camera after `turn` in [0, 1) of its circle, starting from the front, where the scene leaves it to us.
Camera turntable_camera(const CameraDescription& description, const TurntableFit& fit, double turn);

/// A camera, as at time 0, that has gone `turn` in [0, 1) of a circle around the box, starting from the front.
Camera turntable_camera(const CameraDescription& description, const Box& box, double aspect, double turn);

}  // namespace umax
