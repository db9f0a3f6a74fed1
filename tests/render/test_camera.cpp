#include "render/scene/camera.h"

#include <cmath>

#include "core/base/error.h"
#include "tests/support/catch.h"

using namespace umax;

TEST_CASE("the middle of the picture looks at the target, its edges at half the field of view") {
  Camera camera;
  camera.position = {1, 2, 6};
  camera.target = {0, 1, -1};
  camera.vertical_fov_degrees = 40;
  const CameraView view = make_camera_view(camera, 300, 200);
  const Vector3f middle = camera_ray(view, 150, 100, {0.5f, 0.5f}).direction;
  CHECK((middle - (camera.target - camera.position).normalized()).norm() < 1e-6f);
  const Vector3f top = camera_ray(view, 150, 0, {0.5f, 0.5f}).direction;
  const Vector3f right = camera_ray(view, 300, 100, {0.5f, 0.5f}).direction;
  CHECK(std::acos(top.dot(middle)) == Approx(20 * 3.14159265 / 180).epsilon(1e-4));
  CHECK(std::acos(right.dot(middle)) == Approx(std::atan(1.5 * std::tan(20 * 3.14159265 / 180))).epsilon(1e-4));
  CHECK(top.y() > middle.y());
  CHECK(right.dot(view.right) > 0);
}

TEST_CASE("rays through a lens meet at the focus distance") {
  Camera camera;
  camera.aperture_radius = 0.1f;
  const float focus = GENERATE(0.0f, 3.0f);
  camera.focus_distance = focus;
  const CameraView view = make_camera_view(camera, 64, 64);
  const float distance = focus > 0 ? focus : (camera.target - camera.position).norm();
  const auto at_focus = [&](const Vector2f& lens) {
    const Ray ray = camera_ray(view, 10, 20, lens);
    return Vector3f(ray.origin + ray.direction * (distance / ray.direction.dot(view.forward)));
  };
  CHECK((at_focus({0.1f, 0.2f}) - at_focus({0.9f, 0.7f})).norm() < 1e-5f);
  CHECK((camera_ray(view, 10, 20, {0.0f, 0.5f}).origin - camera.position).norm() == Approx(0.1f));
}

TEST_CASE("a camera that looks nowhere is refused") {
  Camera camera;
  SECTION("target at the position") {
    camera.target = camera.position;
  }
  SECTION("straight up") {
    camera.target = camera.position + camera.up;
  }
  SECTION("no field of view") {
    camera.vertical_fov_degrees = 0;
  }
  SECTION("a field of view of half the sphere") {
    camera.vertical_fov_degrees = 180;
  }
  SECTION("not a number") {
    camera.position.x() = NAN;
  }
  CHECK_THROWS_AS(make_camera_view(camera, 64, 64), Error);
}
