// Anatomy of the figure as signed distances: rounded cones and ellipsoids joined smoothly, and plates grown from them.
// Lengths in metres for a figure about 2 m tall. Parts at x > 0 stand for a pair; a pose then breaks the symmetry a
// little.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "core/base/types.h"

namespace umax::figure {

constexpr double far_away = std::numeric_limits<double>::max();

/// Smooth minimum with compact support: equals min(a, b) where |a - b| >= blend; twice differentiable.
inline double smooth_min(double a, double b, double blend) {
  const double near = blend - std::abs(a - b);
  if (near <= 0) return std::min(a, b);
  return std::min(a, b) - near * near * near / (6 * blend * blend);
}
inline double smooth_max(double a, double b, double blend) {
  return -smooth_min(-a, -b, blend);
}

/// 0 below `low`, 1 above `high`, cubic between; `low` may exceed `high`.
inline double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

struct RoundCone {
  Vector3d a, b;              // [m] centres of the end spheres
  double radius_a, radius_b;  // [m]
  double blend = 0;           // [m] to what stands before it in its part
};
struct Ellipsoid {
  Vector3d centre, radii;                // [m]
  Matrix3d axes = Matrix3d::Identity();  // rows: the ellipsoid's axes in figure space
  double blend = 0;                      // [m]
};
using Primitive = std::variant<RoundCone, Ellipsoid>;

double distance_to(const RoundCone& cone, const Vector3d& p);
double distance_to(const Ellipsoid& ellipsoid, const Vector3d& p);  // first order: exact on the surface

/// Primitives joined in their order, with a ball around all of them.
struct Part {
  std::vector<Primitive> primitives;
  bool mirrored = false;  // stands at x > 0 and has a twin at x < 0
  Vector3d centre{0, 0, 0};
  double radius = 0;  // [m]
};

struct Anatomy {
  Part torso, dome, shoulders, hips, legs, toes, toe_claws, tail;  // in body coordinates
  Part head, ears, ear_hollows, eyes, eyelids, nose, nostrils;     // in head coordinates
  Part arms, fingers, finger_claws;                                // in arm coordinates
};
Anatomy make_anatomy();

/// A point as its parts see it. The parts are built symmetric and then posed: the head a little tilted, one arm higher.
struct PosedPoint {
  Vector3d body, head, arm;  // [m] x >= 0 by folding
  double side = 1;           // which side of the head's middle plane: 1 or -1
};
constexpr double head_scale = 1.13;  // metres per unit of head coordinates
PosedPoint posed(const Vector3d& p);

/// Eyes, mouth and nose, where small triangles show.
bool on_face(const Vector3d& p);

/// Signed distances [m] at a point: of the parts that painting tells apart, and of all together.
struct Distances {
  double skin = far_away;  // everything soft, carved
  double torso = far_away, head = far_away, ears = far_away, ear_hollows = far_away, tail = far_away;
  double legs = far_away, arms = far_away;
  double shell_base = far_away;                                // torso with shoulders and hips: what the shell lies on
  double shell = far_away, cap = far_away, guards = far_away;  // the plates
  double eyes = far_away, nose = far_away, claws = far_away;
  double all = far_away;
};

/// Distances that are right where |all| <= reach; further parts may be left at far_away.
Distances distances(const Anatomy& anatomy, const PosedPoint& p, double reach);

/// Where a point lies on the armour.
struct PlatePattern {
  double height = 0;  // [m] to add to the plate's thickness
  double groove = 0;  // [0, 1] 1 in the seams between tiles
  double rim = 0;     // [0, 1] 1 at the raised edge of a band
  double tint = 0;    // [-1, 1] constant on a tile
};
PlatePattern shell_pattern(const Vector3d& body);
PlatePattern cap_pattern(const Vector3d& head);
PlatePattern tail_pattern(const Vector3d& body);
PlatePattern guard_pattern(const PosedPoint& p);
double shell_distance(double shell_base, const Vector3d& body, double reach);
double cap_distance(double head, const Vector3d& head_point, double reach);
double guards_distance(double arms, double legs, const PosedPoint& p, double reach);

/// [m] to be added to the skin's distance: belly bands and the mouth. Positive carves.
double skin_relief(const Distances& d, const PosedPoint& p);
double mouth_line(const Vector3d& head);  // [0, 1] 1 in the line of the mouth

/// Linear Rec. 709 colour of a point on the surface with outward unit normal n.
Vector3d paint(const Anatomy& anatomy, const Vector3d& p, const Vector3d& n);

}  // namespace umax::figure
