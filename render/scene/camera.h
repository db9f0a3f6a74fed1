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

/// Ray through the place (x, y) [px, from the upper left corner]; lens: uniform square, for the thin lens.
Ray camera_ray(const CameraView& view, float x, float y, const Vector2f& lens);

}  // namespace umax
