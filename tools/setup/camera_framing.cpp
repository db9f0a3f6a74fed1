#include "tools/setup/camera_framing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "embedding/cameras/moving_camera.h"

namespace umax {
namespace {

constexpr double margin = 1.12;                           // [-] picture over box
const Vector3d from_the_front = Vector3d(0.30, 0.20, 1);  // target to camera

Points corners_of(const Box& box) {
  Points corners(8, 3);
  for (int i = 0; i < 8; ++i) corners.row(i) = box.corner(Box::CornerType(i)).transpose();
  return corners;
}

/// How far from the target the camera must stand, in the direction `back`, to have all points in the picture.
double fitting_distance(const Points& points, const Vector3d& target, const Vector3d& back, double vertical_fov_degrees,
                        double aspect) {
  const double tan_vertical = std::tan(vertical_fov_degrees * std::numbers::pi / 360) / margin;
  const double tan_horizontal = tan_vertical * aspect;
  const Vector3d right = Vector3d::UnitY().cross(back).normalized(), up = back.cross(right);
  double distance = 1e-3 * (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
  for (const auto& point : points.rowwise()) {
    const Vector3d from_target = point.transpose() - target;
    const double sideways =
        std::max(std::abs(from_target.dot(right)) / tan_horizontal, std::abs(from_target.dot(up)) / tan_vertical);
    distance = std::max(distance, from_target.dot(back) + sideways);
  }
  return distance;
}

Camera camera_at(const CameraDescription& description, const Vector3d& position, const Vector3d& target,
                 double time = 0) {
  Camera camera;
  camera.position = position.cast<float>();
  camera.target = target.cast<float>();
  camera.vertical_fov_degrees = float(description.vertical_fov_degrees.at(time));
  camera.aperture_radius = float(description.aperture_radius.at(time));
  camera.focus_distance = float(description.focus_distance.at(time));
  return camera;
}

/// The file's camera; its target, which is where it is sharp, as far away as the middle of the box.
Camera camera_of_file(const CameraDescription& description, const Box& box, double time) {
  const MovingCamera& moving = *description.motion;
  const CameraPlace place = moving.at(description.start.value_or(moving.start) + time);
  const double depth = box.isEmpty() ? 0 : (box.center() - place.position).dot(place.forward);
  Camera camera =
      camera_at(description, place.position, place.position + (depth > 0 ? depth : 1.0) * place.forward, time);
  camera.up = place.up.cast<float>();
  camera.vertical_fov_degrees = float(place.vertical_fov_degrees);
  return camera;
}

/// Axes of a picture that is seen from `back`.
struct ViewAxes {
  Vector3d right, up, back;
  explicit ViewAxes(const Vector3d& towards_camera) : back(towards_camera.normalized()) {
    right = Vector3d::UnitY().cross(back).normalized();
    up = back.cross(right);
  }
};

double tangent_of(double vertical_fov_degrees) {
  return std::tan(vertical_fov_degrees * std::numbers::pi / 360) / margin;
}

}  // namespace

ViewFit view_fit(const CameraDescription& description, double aspect) {
  return {.aspect = aspect, .vertical_fov_degrees = description.vertical_fov_degrees.at(0)};
}

bool ViewFit::fits(const CameraDescription& description, double picture_aspect) const {
  return aspect == picture_aspect && vertical_fov_degrees == description.vertical_fov_degrees.at(0);
}

// A point is in the picture where p_r - c_r <= t (c_b - p_b), and likewise at the other sides: c, the camera; r, b, the
// picture's right and the way back; t, the tangent of half the angle of view. So p_r + t p_b is all that counts of it.
void ViewFit::extend(const Points& points) {
  const ViewAxes axes(from_the_front);
  const double vertical = tangent_of(vertical_fov_degrees), horizontal = vertical * aspect;
  for (const auto& row : points.rowwise()) {
    const Vector3d point = row.transpose();
    const double r = point.dot(axes.right), u = point.dot(axes.up), b = point.dot(axes.back);
    right = std::max(right, r + horizontal * b);
    left = std::max(left, -r + horizontal * b);
    top = std::max(top, u + vertical * b);
    bottom = std::max(bottom, -u + vertical * b);
    near = std::max(near, b);
    far = std::min(far, b);
  }
}

Camera frame_camera(const CameraDescription& description, const ViewFit& fit, double time) {
  if (fit.is_empty()) return frame_camera(description, Box(Vector3d(0, 0, 0), Vector3d(0, 0, 0)), fit.aspect, time);
  const ViewAxes axes(from_the_front);
  const double vertical = tangent_of(fit.vertical_fov_degrees), horizontal = vertical * fit.aspect;
  // both sides touch what they are nearest to
  const double depth = std::max({(fit.right + fit.left) / (2 * horizontal), (fit.top + fit.bottom) / (2 * vertical),
                                 fit.near + 1e-3 * (fit.near - fit.far)});
  const Vector3d across = (fit.right - fit.left) / 2 * axes.right + (fit.top - fit.bottom) / 2 * axes.up;
  return camera_at(description, across + depth * axes.back, across + (fit.near + fit.far) / 2 * axes.back, time);
}

// The same for points that go once round: of each, the farthest place on its circle counts.
TurntableFit turntable_fit(const CameraDescription& description, const Points& points, double aspect) {
  const double vertical = tangent_of(description.vertical_fov_degrees.at(0)), horizontal = vertical * aspect;
  const Vector3d front = from_the_front.normalized();
  const double sine = front.y(), cosine = std::hypot(front.x(), front.z());
  TurntableFit fit;
  fit.center = 0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose();
  double side = -ViewFit::infinite, top = side, bottom = side, near = side;
  for (const auto& row : points.rowwise()) {
    const Vector3d p = row.transpose() - fit.center;
    const double radius = std::hypot(p.x(), p.z()), height = p.y();
    side = std::max(side, radius * std::hypot(1, horizontal * cosine) + horizontal * height * sine);
    top = std::max(top, height * (cosine + vertical * sine) + radius * std::abs(vertical * cosine - sine));
    bottom = std::max(bottom, height * (vertical * sine - cosine) + radius * std::abs(vertical * cosine + sine));
    near = std::max(near, height * sine + radius * cosine);
  }
  fit.distance = std::max({side / horizontal, (top + bottom) / (2 * vertical), 1.001 * near});
  fit.height = (top - bottom) / 2;
  return fit;
}

Camera turntable_camera(const CameraDescription& description, const TurntableFit& fit, double turn) {
  const Eigen::AngleAxisd turned(2 * std::numbers::pi * turn, Vector3d::UnitY());
  const ViewAxes axes(turned * from_the_front);
  const Vector3d target = fit.center + fit.height * axes.up;
  return camera_at(description, target + fit.distance * axes.back, target);
}

Camera frame_camera(const CameraDescription& description, const Box& box, double aspect, double time) {
  if (description.motion) return camera_of_file(description, box, time);
  const Vector3d target = description.target ? description.target->at(time) : Vector3d(box.center());
  if (description.position) return camera_at(description, description.position->at(time), target, time);
  const Vector3d back = from_the_front.normalized();
  return camera_at(
      description,
      target + back * fitting_distance(corners_of(box), target, back, description.vertical_fov_degrees.at(0), aspect),
      target, time);
}

Camera frame_points(const CameraDescription& description, const Points& points, double aspect, const Vector3d& back) {
  // the middle of what is seen along the picture's axes
  const Vector3d right = Vector3d::UnitY().cross(back).normalized(), up = back.cross(right);
  Vector3d target = Vector3d::Zero();
  for (const Vector3d& axis : {right, up, back}) {
    const VectorXd along = points * axis;
    target += 0.5 * (along.minCoeff() + along.maxCoeff()) * axis;
  }
  return camera_at(
      description,
      target + back * fitting_distance(points, target, back, description.vertical_fov_degrees.at(0), aspect), target);
}

Camera turntable_camera(const CameraDescription& description, const Box& box, double aspect, double turn) {
  // the box's own circle, so that nothing leaves the picture on the way round
  const double radius = 0.5 * std::hypot(box.sizes().x(), box.sizes().z());
  const Vector3d half(radius, 0.5 * box.sizes().y(), radius);
  const Box round(box.center() - half, box.center() + half);
  const Vector3d target = description.target ? description.target->at(0) : Vector3d(box.center());
  const Vector3d from_target = description.position ? Vector3d(description.position->at(0) - target) : from_the_front,
                 front = from_target.normalized();
  const double distance =
      description.position
          ? from_target.norm()
          : fitting_distance(corners_of(round), target, Vector3d(0, front.y(), std::hypot(front.x(), front.z())),
                             description.vertical_fov_degrees.at(0), aspect);
  const Vector3d back = Eigen::AngleAxisd(2 * std::numbers::pi * turn, Vector3d::UnitY()) * front;
  return camera_at(description, target + back * distance, target);
}

}  // namespace umax
