#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/catch.h"
#include "tools/pictures/shot.h"
#include "tools/setup/camera_framing.h"

using namespace umax;

namespace {

/// Largest |x| and |y| of the box's corners in the picture, where 1 is its edge; huge for corners behind the camera.
double extent_in_picture(const Camera& camera, const Box& box, double aspect) {
  const Vector3d position = camera.position.cast<double>(),
                 forward = (camera.target.cast<double>() - position).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitY()).normalized(), up = right.cross(forward);
  const double tangent = std::tan(double(camera.vertical_fov_degrees) * std::numbers::pi / 360);
  double extent = 0;
  for (int i = 0; i < 8; ++i) {
    const Vector3d d = box.corner(Box::CornerType(i)) - position;
    const double depth = d.dot(forward);
    if (depth <= 0) return 1e9;
    extent = std::max(
        {extent, std::abs(d.dot(up)) / (depth * tangent), std::abs(d.dot(right)) / (depth * tangent * aspect)});
  }
  return extent;
}

const std::vector<Box> boxes{
    Box(Vector3d(-1, 0, -1), Vector3d(1, 2, 1)), Box(Vector3d(0, -0.9, -0.06), Vector3d(1, 0.06, 0.06)),
    Box(Vector3d(-0.01, 5, -0.3), Vector3d(0.01, 9, 0.3)), Box(Vector3d(-8, 0, -8), Vector3d(8, 0.1, 8))};

}  // namespace

TEST_CASE("a camera that is not given shows the whole motion and fills the picture with it") {
  for (const Box& box : boxes)
    for (const double aspect : {16.0 / 9, 1.0, 0.5}) {
      const double extent = extent_in_picture(frame_camera({}, box, aspect), box, aspect);
      CHECK(extent <= 1.0);
      CHECK(extent >= 0.8);
    }
}

TEST_CASE("a camera that is given stays where it is") {
  CameraDescription description;
  description.position = Vector3d(1, 2, 9);
  description.target = Vector3d(0, 1, 0);
  const Camera camera = frame_camera(description, boxes[0], 1);
  CHECK(camera.position == Vector3f(1, 2, 9));
  CHECK(camera.target == Vector3f(0, 1, 0));
}

TEST_CASE("nothing leaves the picture while a turntable goes round, and it ends where it began") {
  for (const Box& box : boxes) {
    for (const double turn : {0.0, 0.1, 0.25, 0.4, 0.5, 0.75, 0.9})
      CHECK(extent_in_picture(turntable_camera({}, box, 1.5, turn), box, 1.5) <= 1.0);
    CHECK((turntable_camera({}, box, 1.5, 0).position - turntable_camera({}, box, 1.5, 1).position).norm() <
          1e-4f * float(box.diagonal().norm()));
  }
}

TEST_CASE("a camera that frames a motion touches it at two opposite sides, and cuts nothing off") {
  // places of a fall: a swarm that is narrow above and wide below, added in two parts
  Points swarm(400, 3);
  for (Eigen::Index i = 0; i < swarm.rows(); ++i) {
    const double t = double(i) / 400, angle = 2.4 * double(i);
    swarm.row(i) << (0.2 + t) * std::cos(angle), 3 - 3 * t, (0.2 + t) * std::sin(angle);
  }
  for (const double aspect : {16.0 / 9, 1.0, 0.5}) {
    ViewFit fit = view_fit({}, aspect);
    CHECK(fit.is_empty());
    fit.extend(swarm.topRows(150));
    fit.extend(swarm.bottomRows(250));
    const Camera camera = frame_camera({}, fit);
    const Vector3d position = camera.position.cast<double>(),
                   forward = (camera.target.cast<double>() - position).normalized();
    const Vector3d right = forward.cross(Vector3d::UnitY()).normalized(), up = right.cross(forward);
    const double tangent = std::tan(double(camera.vertical_fov_degrees) * std::numbers::pi / 360);
    Box seen;  // x and y in the picture, where 1 is its edge
    for (const auto& row : swarm.rowwise()) {
      const Vector3d d = row.transpose() - position;
      const double depth = d.dot(forward);
      seen.extend(Vector3d(d.dot(right) / (depth * tangent * aspect), d.dot(up) / (depth * tangent), 0));
    }
    const double wide = std::min(-seen.min().x(), seen.max().x()), high = std::min(-seen.min().y(), seen.max().y());
    CHECK(seen.min().head<2>().cwiseAbs().maxCoeff() <= 1 / 1.12 + 1e-4);
    CHECK(seen.max().head<2>().cwiseAbs().maxCoeff() <= 1 / 1.12 + 1e-4);
    CHECK(std::max(wide, high) == Approx(1 / 1.12).margin(1e-4));
    // a box around it needs more room
    const Box box(Vector3d(swarm.colwise().minCoeff().transpose()), Vector3d(swarm.colwise().maxCoeff().transpose()));
    const Camera of_box = frame_camera({}, box, aspect);
    CHECK((of_box.position - of_box.target).norm() > (camera.position - camera.target).norm());
  }
}

TEST_CASE("the circle round points cuts nothing off, and they fill the picture somewhere on the way") {
  Points bar(60, 3);
  for (Eigen::Index i = 0; i < bar.rows(); ++i) bar.row(i) << 5 + 0.05 * double(i), 1 + 0.02 * double(i % 7), -2;
  for (const double aspect : {16.0 / 9, 0.5}) {
    const TurntableFit fit = turntable_fit({}, bar, aspect);
    double largest = 0;
    for (int k = 0; k < 90; ++k)
      for (const auto& row : bar.rowwise()) {
        const Box place(Vector3d(row.transpose()), Vector3d(row.transpose()));
        largest = std::max(largest, extent_in_picture(turntable_camera({}, fit, k / 90.0), place, aspect));
      }
    CHECK(largest <= 1 / 1.12 + 1e-3);
    CHECK(largest >= 0.97 / 1.12);
  }
}

TEST_CASE("a light shines on its target with its power, whatever its size") {
  for (const double size : {0.5, 2.0}) {
    LightDescription description;
    description.position = Vector3d(3, 5, -2);
    description.target = Vector3d(0, 1, 0);
    description.size = size;
    description.power = 100;
    const AreaLight light = area_light(description);
    const Vector3f normal = light.edge_u.cross(light.edge_v),
                   centre = light.corner + 0.5f * (light.edge_u + light.edge_v);
    CHECK((centre - Vector3f(3, 5, -2)).norm() < 1e-5f);
    CHECK(normal.normalized().dot(Vector3f(-3, -4, 2).normalized()) == Approx(1));
    CHECK(double(light.radiance.x()) * std::numbers::pi * double(normal.norm()) == Approx(100));
  }
}
