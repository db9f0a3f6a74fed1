#include <algorithm>
#include <cmath>

#include "embedding/figure/figure_shape.h"

namespace umax::figure {
namespace {

const Vector3d skin_color(0.56, 0.215, 0.08), belly_color(0.80, 0.58, 0.36), plate_color(0.05, 0.125, 0.13);
const Vector3d plate_rim_color(0.24, 0.37, 0.35), groove_color(0.018, 0.03, 0.035), ear_color(0.70, 0.24, 0.18);
const Vector3d nose_color(0.035, 0.018, 0.018), claw_color(0.75, 0.62, 0.45), mouth_color(0.16, 0.045, 0.03);
const Vector3d blush_color(0.72, 0.20, 0.12), limb_color(0.36, 0.10, 0.038);

Vector3d mix(const Vector3d& a, const Vector3d& b, double t) {
  return a + (b - a) * std::clamp(t, 0.0, 1.0);
}

Vector3d plate(const PlatePattern& pattern) {
  const Vector3d tinted = (1 + 0.35 * pattern.tint) * plate_color;
  return mix(mix(tinted, plate_rim_color, 0.8 * pattern.rim), groove_color, 0.8 * pattern.groove);
}

Vector3d skin(const Distances& d, const PosedPoint& p, const Vector3d& n) {
  Vector3d color = skin_color;
  // darker hands and feet, and the warm shade of creases under the plates
  const double hand = smooth_step(0.60, 0.80, p.arm.x()) * (p.body.y() > 0.8);
  const double foot = smooth_step(0.22, 0.05, p.body.y()) * (p.body.z() > -0.3);
  color = mix(color, limb_color, 0.8 * std::max(hand, foot));
  color *= 1 - 0.35 * smooth_step(0.05, 0.0, std::min(d.shell, std::min(d.cap, d.guards)));
  // belly: a light oval on the front of the torso
  const double oval = std::hypot(p.body.x() / 0.25, (p.body.y() - 0.78) / 0.44);
  const double belly = smooth_step(1.0, 0.90, oval) * smooth_step(0.02, 0.12, p.body.z()) *
                       smooth_step(0.02, 0.05, d.legs) * smooth_step(0.0, 0.03, d.arms);
  color = mix(color, belly_color, belly);
  if (d.head < 0.02) {
    // lighter under the snout, blush on the cheeks
    color = mix(color, belly_color, smooth_step(0.13, 0.24, p.head.z()) * smooth_step(1.385, 1.325, p.head.y()));
    const double blush = (p.head - Vector3d(0.215, 1.375, 0.19)).norm();
    color = mix(color, blush_color, 0.75 * smooth_step(0.085, 0.02, blush));
    color = mix(color, mouth_color, smooth_step(0.35, 0.75, mouth_line(p.head)));
  }
  const double in_ear = smooth_step(0.012, -0.004, d.ear_hollows) * smooth_step(0.0, 0.5, n.z());
  if (d.ears < 0.02) color = mix(color, ear_color, in_ear);
  if (d.tail < 0.006) color = mix(color, plate(tail_pattern(p.body)), smooth_step(0.03, 0.05, d.torso));
  return color;
}

double angle_between(const Vector3d& unit, const Vector3d& direction) {
  return std::acos(std::clamp(unit.dot(direction.normalized()), -1.0, 1.0));
}

Vector3d eye(const Anatomy& anatomy, const PosedPoint& p) {
  const Vector3d centre = std::get<Ellipsoid>(anatomy.eyes.primitives[0]).centre;
  const Vector3d toward = (p.head - centre).normalized();
  const double angle = angle_between(toward, {0.16, 0.02, 1});
  Vector3d color(0.78, 0.74, 0.68);
  color = mix(color, Vector3d(0.03, 0.012, 0.008), smooth_step(0.96, 0.90, angle));
  color = mix(color, Vector3d(0.24, 0.085, 0.022), smooth_step(0.87, 0.80, angle));
  color = mix(color, Vector3d(0.006, 0.005, 0.006), smooth_step(0.66, 0.56, angle));
  // glints on the same side of both eyes, as one lamp would make them
  const double large = smooth_step(0.27, 0.20, angle_between(toward, {p.side * 0.30, 0.36, 1}));
  const double small = smooth_step(0.14, 0.08, angle_between(toward, {p.side * -0.26, -0.30, 1}));
  return mix(color, Vector3d(0.95, 0.95, 0.95), std::max(large, 0.8 * small));
}

}  // namespace

Vector3d paint(const Anatomy& anatomy, const Vector3d& point, const Vector3d& n) {
  const PosedPoint p = posed(point);
  const Distances d = distances(anatomy, p, 0.02);
  // the nearest part gives the colour, with a soft border about as wide as a triangle
  Vector3d color = skin(d, p, n);
  const auto cover = [&](double part, const Vector3d& over) {
    color = mix(color, over, smooth_step(0.006, 0.001, part - d.all));
  };
  cover(d.shell, plate(shell_pattern(p.body)));
  cover(d.cap, plate(cap_pattern(p.head)));
  cover(d.guards, plate(guard_pattern(p)));
  cover(d.eyes, eye(anatomy, p));
  cover(d.nose, nose_color);
  cover(d.claws, claw_color);
  return color;
}

}  // namespace umax::figure
