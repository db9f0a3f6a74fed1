#include "render/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "render/scene/sampling.h"

namespace umax {

CameraView make_camera_view(const Camera& camera, int width, int height) {
  if (!(camera.vertical_fov_degrees > 0 && camera.vertical_fov_degrees < 180)) {
    throw Error(Fault::bad_data, {.where = "camera.vertical_fov_degrees",
                                  .what = "must lie between 0 and 180 degrees",
                                  .value = std::to_string(camera.vertical_fov_degrees),
                                  .remedy = "35 is a usual value"});
  }
  CameraView view;
  const Vector3f line_of_sight = camera.target - camera.position;
  const Vector3f right = line_of_sight.cross(camera.up);
  if (!(right.norm() > 1e-6f * line_of_sight.norm() * camera.up.norm()) || !right.allFinite()) {
    throw Error(Fault::bad_data, {.where = "camera",
                                  .what = "looks nowhere: target at the position, or straight along up",
                                  .value = "",
                                  .remedy = "move camera.position or camera.target"});
  }
  view.position = camera.position;
  view.forward = line_of_sight.normalized();
  view.right = right.normalized();
  view.up = view.right.cross(view.forward);
  const float half_height = float(std::tan(double(camera.vertical_fov_degrees) * 3.14159265358979 / 360));
  const float pixel = 2 * half_height / float(height);
  view.step_x = view.right * pixel;
  view.step_y = -view.up * pixel;
  view.corner = view.forward + view.up * half_height - view.right * (half_height * float(width) / float(height));
  view.aperture_radius = camera.aperture_radius;
  view.focus_distance = camera.focus_distance > 0 ? camera.focus_distance : line_of_sight.norm();
  return view;
}

CameraView camera_at(const std::vector<CameraView>& views, float time) {
  if (views.size() < 2) return views.front();
  const float position = time * float(views.size() - 1);
  const std::size_t before = std::min(std::size_t(position), views.size() - 2);
  const CameraView &a = views[before], &b = views[before + 1];
  const float share = position - float(before), rest = 1 - share;
  CameraView view;
  view.position = rest * a.position + share * b.position;
  view.right = (rest * a.right + share * b.right).normalized();
  view.up = (rest * a.up + share * b.up).normalized();
  view.forward = (rest * a.forward + share * b.forward).normalized();
  view.corner = rest * a.corner + share * b.corner;
  view.step_x = rest * a.step_x + share * b.step_x;
  view.step_y = rest * a.step_y + share * b.step_y;
  view.aperture_radius = rest * a.aperture_radius + share * b.aperture_radius;
  view.focus_distance = rest * a.focus_distance + share * b.focus_distance;
  return view;
}

CameraView view_at(const RenderScene& scene, float time, int width, int height) {
  if (scene.camera_path.size() < 2) return make_camera_view(scene.camera, width, height);
  std::vector<CameraView> views;
  for (const Camera& camera : scene.camera_path) views.push_back(make_camera_view(camera, width, height));
  return camera_at(views, time);
}

CameraView view_at_moment(const RenderScene& scene, int width, int height) {
  return view_at(scene, scene.moment, width, height);
}

Ray camera_ray(const CameraView& view, float x, float y, const Vector2f& lens) {
  Ray ray;
  const Vector3f direction = view.corner + x * view.step_x + y * view.step_y;
  ray.origin = view.position;
  ray.direction = direction.normalized();
  if (view.aperture_radius > 0) {
    const Vector2f disc = view.aperture_radius * disc_from_square(lens);
    const Vector3f shift = disc.x() * view.right + disc.y() * view.up;
    ray.origin += shift;
    ray.direction = (direction * view.focus_distance - shift).normalized();
  }
  return ray;
}

}  // namespace umax
