#include <algorithm>
#include <cmath>

#include "embedding/figure_shape.h"

namespace umax::figure {
namespace {

constexpr double widest_blend = 0.20;  // [m] parts further than this beyond the reach cannot matter
constexpr double twin_range = 0.20;    // [m] from the middle plane within which the mirrored twin matters

double primitives_distance(const Part& part, const Vector3d& p) {
  double d = far_away;
  for (const Primitive& primitive : part.primitives) {
    const double next = std::visit([&](const auto& shape) { return distance_to(shape, p); }, primitive);
    const double blend = std::visit([](const auto& shape) { return shape.blend; }, primitive);
    d = blend > 0 ? smooth_min(d, next, blend) : std::min(d, next);
  }
  return d;
}

double part_distance(const Part& part, const Vector3d& p, double reach) {
  const auto within = [&](const Vector3d& q) { return (q - part.centre).norm() <= part.radius + reach; };
  double d = within(p) ? primitives_distance(part, p) : far_away;
  if (part.mirrored && std::abs(p.x()) < twin_range) {
    const Vector3d twin(-p.x(), p.y(), p.z());
    if (within(twin)) d = smooth_min(d, primitives_distance(part, twin), 0.05);
  }
  return d;
}

/// Upper lid: a skin over the eye above a plane that falls outwards.
double eyelid_distance(const Anatomy& anatomy, const Vector3d& p, double reach) {
  const double lid = part_distance(anatomy.eyelids, p, reach);
  if (lid == far_away) return far_away;
  static const Vector3d above = Vector3d(-0.10, 0.80, -0.52).normalized();
  const Vector3d centre = std::get<Ellipsoid>(anatomy.eyes.primitives[0]).centre;
  return smooth_max(lid, -(p - centre).dot(above) + 0.004, 0.014);
}

void soft_parts(const Anatomy& anatomy, const Vector3d& p, double reach, Distances& d) {
  d.torso = part_distance(anatomy.torso, p, reach);
  d.legs = smooth_min(part_distance(anatomy.legs, p, reach), part_distance(anatomy.toes, p, reach), 0.03);
  d.arms = smooth_min(part_distance(anatomy.arms, p, reach), part_distance(anatomy.fingers, p, reach), 0.025);
  d.tail = part_distance(anatomy.tail, p, reach);
  d.head = part_distance(anatomy.head, p, reach);
  d.ears = part_distance(anatomy.ears, p, reach);
  d.ear_hollows = part_distance(anatomy.ear_hollows, p, reach);
  if (d.tail < reach) d.tail -= tail_pattern(p).height;
  const double carved_ears = d.ear_hollows == far_away ? d.ears : smooth_max(d.ears, -d.ear_hollows, 0.02);
  d.eyelids = eyelid_distance(anatomy, p, reach);
  d.skin = smooth_min(d.torso, d.legs, 0.10);
  d.skin = smooth_min(d.skin, d.tail, 0.08);
  d.skin = smooth_min(d.skin, d.arms, 0.07);
  d.skin = smooth_min(d.skin, d.head, 0.06);
  d.skin = smooth_min(d.skin, carved_ears, 0.05);
  d.skin = smooth_min(d.skin, d.eyelids, 0.018);
}

}  // namespace

Distances distances(const Anatomy& anatomy, const Vector3d& point, double reach) {
  const Vector3d p(std::abs(point.x()), point.y(), point.z());
  const double wide = reach + widest_blend;
  Distances d;
  soft_parts(anatomy, p, wide, d);
  if (d.skin < wide) d.skin += skin_relief(d, p);
  d.shell = shell_distance(d.torso, p);
  d.cap = cap_distance(d.head, p);
  d.eyes = part_distance(anatomy.eyes, p, wide);
  d.nose = part_distance(anatomy.nose, p, wide);
  d.claws = part_distance(anatomy.claws, p, wide);
  if (d.nose < wide) d.nose = smooth_max(d.nose, -part_distance(anatomy.nostrils, p, wide), 0.01);
  // hard things stand in creases of the soft ones; the soles are flat
  d.all = smooth_min(d.skin, d.shell, 0.012);
  d.all = smooth_min(d.all, d.cap, 0.012);
  d.all = smooth_min(d.all, d.eyes, 0.006);
  d.all = smooth_min(d.all, d.nose, 0.012);
  d.all = smooth_min(d.all, d.claws, 0.010);
  d.all = smooth_max(d.all, -p.y(), 0.02);
  return d;
}

}  // namespace umax::figure
