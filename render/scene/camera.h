// The camera as the path tracer uses it: from a place in the picture to a ray.
#pragma once

#include <vector>

#include "render/scene/ray.h"
#include "render/scene/render_scene.h"

namespace umax {

/// Camera with its frame worked out for one picture size.
struct CameraView {
  Vector3f position, right, up, forward;  // orthonormal
  Vector3f corner;                        // direction to the picture's upper left corner, at distance 1 along forward
  Vector3f step_x, step_y;                // per pixel, likewise
  float aperture_radius = 0, focus_distance = 1;
};

/// Throws Error 65 when the camera looks nowhere (target at position, up along the view, fov outside (0, 180)).
CameraView make_camera_view(const Camera& camera, int width, int height);

/// The view at a time in [0, 1], between the two of the views that stand around it at even times.
CameraView camera_at(const std::vector<CameraView>& views, float time);

/// The scene's view at a time while the shutter is open: 0 as it opens, 1 as it closes.
CameraView view_at(const RenderScene& scene, float time, int width, int height);

/// The same at the scene's own moment.
CameraView view_at_moment(const RenderScene& scene, int width, int height);

/// Where in the picture a point is.
struct Projection {
  CameraView view;
  float pixels_at_one = 1;  // [px] of a length at distance 1 along the line of sight

  explicit Projection(const CameraView& view_) : view(view_), pixels_at_one(1 / view_.step_x.norm()) {}
  float depth(const Vector3f& point) const { return (point - view.position).dot(view.forward); }
  /// [px] right of and above the middle; of what is behind the camera nothing sensible.
  Vector2f place(const Vector3f& point) const { return place_of_direction(point - view.position); }
  Vector2f place_of_direction(const Vector3f& from) const {
    return Vector2f(from.dot(view.right), from.dot(view.up)) * (pixels_at_one / from.dot(view.forward));
  }
};

/// Ray through the place (x, y) [px, from the upper left corner]; lens: uniform square, for the thin lens.
Ray camera_ray(const CameraView& view, float x, float y, const Vector2f& lens);

}  // namespace umax
