#include <algorithm>
#include <cmath>

#include "embedding/figure_shape.h"

namespace umax::figure {
namespace {

const Vector3d skin_color(0.62, 0.27, 0.115), belly_color(0.80, 0.58, 0.36), plate_color(0.055, 0.115, 0.125);
const Vector3d plate_rim_color(0.16, 0.24, 0.23), groove_color(0.018, 0.03, 0.035), ear_color(0.70, 0.24, 0.18);
const Vector3d nose_color(0.035, 0.018, 0.018), claw_color(0.75, 0.62, 0.45), mouth_color(0.16, 0.045, 0.03);
const Vector3d blush_color(0.72, 0.20, 0.12);

Vector3d mix(const Vector3d& a, const Vector3d& b, double t) {
  return a + (b - a) * std::clamp(t, 0.0, 1.0);
}

Vector3d plate(const PlatePattern& pattern) {
  return mix(mix(plate_color, plate_rim_color, pattern.rim), groove_color, 0.8 * pattern.groove);
}

Vector3d skin(const Distances& d, const Vector3d& p, const Vector3d& n) {
  Vector3d color = skin_color;
  // belly: a light oval on the front of the torso, running up to the chin
  const double oval = std::hypot(p.x() / 0.25, (p.y() - 0.78) / 0.44);
  const double front = smooth_step(1.0, 0.86, oval) * smooth_step(0.02, 0.12, p.z()) * smooth_step(0.02, 0.05, d.legs) *
                       smooth_step(0.0, 0.03, d.arms);
  color = mix(color, belly_color, front);
  // muzzle: lighter below, and blush on the cheeks
  if (d.head < 0.02) {
    color = mix(color, belly_color, smooth_step(0.15, 0.26, p.z()) * smooth_step(1.40, 1.33, p.y()));
    const double blush = (p - Vector3d(0.205, 1.40, 0.20)).norm();
    color = mix(color, blush_color, 0.75 * smooth_step(0.085, 0.02, blush));
    color = mix(color, mouth_color, smooth_step(0.35, 0.75, mouth_line(p)));
  }
  if (d.ears < 0.02)
    color = mix(color, ear_color, smooth_step(0.012, -0.004, d.ear_hollows) * smooth_step(0.0, 0.5, n.z()));
  if (d.tail < 0.004)
    color = mix(color, plate(tail_pattern(p)), smooth_step(0.03, 0.07, d.torso) * smooth_step(0.2, 0.4, -p.z()));
  return color;
}

Vector3d eye(const Anatomy& anatomy, const Vector3d& p) {
  const Vector3d centre = std::get<Ellipsoid>(anatomy.eyes.primitives[0]).centre;
  const Vector3d toward = (p - centre).normalized();
  static const Vector3d gaze = Vector3d(0.22, 0.05, 1).normalized();
  const double angle = std::acos(std::clamp(toward.dot(gaze), -1.0, 1.0));
  Vector3d color(0.80, 0.76, 0.70);
  color = mix(color, Vector3d(0.03, 0.012, 0.008), smooth_step(0.86, 0.80, angle));
  color = mix(color, Vector3d(0.26, 0.095, 0.025), smooth_step(0.76, 0.68, angle));
  color = mix(color, Vector3d(0.006, 0.005, 0.006), smooth_step(0.52, 0.44, angle));
  return color;
}

double highlight(const Anatomy& anatomy, const Vector3d& point) {
  // the same side of both eyes, as one lamp would make it
  const Vector3d centre = std::get<Ellipsoid>(anatomy.eyes.primitives[0]).centre;
  const double side = point.x() < 0 ? -1 : 1;
  const Vector3d toward = (point - Vector3d(side * centre.x(), centre.y(), centre.z())).normalized();
  static const Vector3d large = Vector3d(0.28, 0.36, 1).normalized(), small = Vector3d(-0.22, -0.30, 1).normalized();
  const double at_large = std::acos(std::clamp(toward.dot(large), -1.0, 1.0));
  const double at_small = std::acos(std::clamp(toward.dot(small), -1.0, 1.0));
  return std::max(smooth_step(0.25, 0.19, at_large), 0.8 * smooth_step(0.13, 0.08, at_small));
}

}  // namespace

Vector3d paint(const Anatomy& anatomy, const Vector3d& point, const Vector3d& n) {
  const Vector3d p(std::abs(point.x()), point.y(), point.z());
  const Distances d = distances(anatomy, point, 0.02);
  // the nearest part gives the colour, with a soft border about as wide as a triangle
  Vector3d color = skin(d, p, n);
  const auto cover = [&](double part, const Vector3d& over) {
    color = mix(color, over, smooth_step(0.006, 0.001, part - d.all));
  };
  cover(d.shell, plate(shell_pattern(p)));
  cover(d.cap, plate(cap_pattern(p)));
  cover(d.eyes, mix(eye(anatomy, p), Vector3d(0.95, 0.95, 0.95), highlight(anatomy, point)));
  cover(d.nose, nose_color);
  cover(d.claws, claw_color);
  return color;
}

}  // namespace umax::figure
