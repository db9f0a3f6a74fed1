#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "embedding/figure/figure_shape.h"

namespace umax::figure {
namespace {

constexpr double shell_reach = 0.26;  // [m] plates and widest blend of what the shell lies on
constexpr double twin_range = 0.20;   // [m] from the middle plane within which the mirrored twin matters
constexpr double degree = 3.14159265358979323846 / 180;

double primitives_distance(const Part& part, const Vector3d& p) {
  double d = far_away;
  for (const Primitive& primitive : part.primitives) {
    const double next = std::visit([&](const auto& shape) { return distance_to(shape, p); }, primitive);
    const double blend = std::visit([](const auto& shape) { return shape.blend; }, primitive);
    d = blend > 0 ? smooth_min(d, next, blend) : std::min(d, next);
  }
  return d;
}

/// far_away where the part is further than `reach`.
double part_distance(const Part& part, const Vector3d& p, double reach) {
  const auto within = [&](const Vector3d& q) { return (q - part.centre).norm() <= part.radius + reach; };
  double d = within(p) ? primitives_distance(part, p) : far_away;
  if (part.mirrored && p.x() < twin_range) {
    const Vector3d twin(-p.x(), p.y(), p.z());
    if (within(twin)) d = smooth_min(d, primitives_distance(part, twin), 0.05);
  }
  return d;
}

Vector3d folded(const Vector3d& p) {
  return {std::abs(p.x()), p.y(), p.z()};
}

/// Upper lid: a skin over the eye above a plane that falls outwards, which looks friendly.
double eyelid_distance(const Anatomy& anatomy, const Vector3d& head, double reach) {
  const double lid = part_distance(anatomy.eyelids, head, reach);
  if (lid == far_away) return far_away;
  static const Vector3d above = Vector3d(0.0, 0.84, -0.54).normalized();
  const Vector3d centre = std::get<Ellipsoid>(anatomy.eyes.primitives[0]).centre;
  return smooth_max(lid, -(head - centre).dot(above) + 0.036, 0.012);
}

/// Distance of a part given in head coordinates, in metres.
double on_head(double d) {
  return d == far_away ? far_away : head_scale * d;
}

void measure_soft_parts(const Anatomy& anatomy, const PosedPoint& p, double reach, Distances& d) {
  // each part is needed as far out as its widest blend, or the plates that lie on it
  const auto body = [&](const Part& part, double blend) { return part_distance(part, p.body, reach + blend); };
  const auto head = [&](const Part& part, double blend) { return on_head(part_distance(part, p.head, reach + blend)); };
  d.torso = body(anatomy.torso, shell_reach);
  d.shell_base = smooth_min(d.torso, body(anatomy.dome, shell_reach), 0.10);
  d.shell_base = smooth_min(d.shell_base, body(anatomy.shoulders, shell_reach), 0.12);
  d.shell_base = smooth_min(d.shell_base, body(anatomy.hips, shell_reach), 0.10);
  d.legs = smooth_min(body(anatomy.legs, 0.10), body(anatomy.toes, 0.10), 0.03);
  d.arms = smooth_min(part_distance(anatomy.arms, p.arm, reach + 0.07),
                      part_distance(anatomy.fingers, p.arm, reach + 0.07), 0.025);
  d.tail = body(anatomy.tail, 0.10);
  if (d.tail < reach + 0.10) d.tail -= tail_pattern(p.body).height;
  d.head = head(anatomy.head, 0.06);
  d.ears = head(anatomy.ears, 0.05);
  d.ear_hollows = d.ears < reach + 0.05 ? head(anatomy.ear_hollows, 0.05) : far_away;
  const double carved_ears = d.ear_hollows == far_away ? d.ears : smooth_max(d.ears, -d.ear_hollows, 0.02);
  d.skin = smooth_min(d.torso, d.legs, 0.10);
  d.skin = smooth_min(d.skin, d.tail, 0.08);
  d.skin = smooth_min(d.skin, d.arms, 0.07);
  d.skin = smooth_min(d.skin, d.head, 0.06);
  d.skin = smooth_min(d.skin, carved_ears, 0.05);
  d.skin = smooth_min(d.skin, on_head(eyelid_distance(anatomy, p.head, reach + 0.02)), 0.014);
}

}  // namespace

PosedPoint posed(const Vector3d& p) {
  static const Vector3d neck(0, 1.22, -0.02), shoulder(-0.22, 1.12, -0.02);
  static const Matrix3d head_from_body =
      (Eigen::AngleAxisd(-7 * degree, Vector3d::UnitZ()) * Eigen::AngleAxisd(-9 * degree, Vector3d::UnitY()))
          .toRotationMatrix()
          .transpose();
  static const Matrix3d arm_from_body =
      Eigen::AngleAxisd(-16 * degree, Vector3d::UnitZ()).toRotationMatrix().transpose();
  const Vector3d head = head_from_body * (p - neck) / head_scale + neck;
  const Vector3d arm = p.x() < 0 ? Vector3d(arm_from_body * (p - shoulder) + shoulder) : p;
  return {folded(p), folded(head), folded(arm), head.x() < 0 ? -1.0 : 1.0};
}

bool on_face(const Vector3d& p) {
  const Vector3d head = posed(p).head;
  const bool eye = (head - Vector3d(0.135, 1.475, 0.235)).norm() < 0.105;
  const bool mouth = head.z() > 0.19 && head.y() > 1.24 && head.y() < 1.38 && head.x() < 0.22;
  const bool nose = head.z() > 0.40 && head.y() > 1.2 && head.y() < 1.45;
  return head.z() > 0.12 && (eye || mouth || nose);
}

Distances distances(const Anatomy& anatomy, const PosedPoint& p, double reach) {
  const double near = reach + 0.02;
  Distances d;
  measure_soft_parts(anatomy, p, reach, d);
  if (d.skin < near) d.skin += skin_relief(d, p);
  d.shell = shell_distance(d.shell_base, p.body, reach);
  d.cap = cap_distance(d.head, p.head, reach);
  d.guards = guards_distance(d.arms, d.legs, p, reach);
  d.eyes = on_head(part_distance(anatomy.eyes, p.head, near));
  d.nose = on_head(part_distance(anatomy.nose, p.head, near));
  if (d.nose < near) d.nose = smooth_max(d.nose, -on_head(part_distance(anatomy.nostrils, p.head, near)), 0.01);
  d.claws = std::min(part_distance(anatomy.toe_claws, p.body, near), part_distance(anatomy.finger_claws, p.arm, near));
  // hard things stand in creases of the soft ones; the soles are flat
  d.all = smooth_min(d.skin, d.shell, 0.012);
  d.all = smooth_min(d.all, d.cap, 0.012);
  d.all = smooth_min(d.all, d.guards, 0.012);
  d.all = smooth_min(d.all, d.eyes, 0.006);
  d.all = smooth_min(d.all, d.nose, 0.012);
  d.all = smooth_min(d.all, d.claws, 0.010);
  d.all = smooth_max(d.all, -p.body.y(), 0.02);
  return d;
}

}  // namespace umax::figure
