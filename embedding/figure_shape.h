// Anatomy of the figure as signed distances: rounded cones and ellipsoids joined smoothly, and plates grown from them.
// Lengths in metres for a figure about 2 m tall. The shape is a function of |x|: left and right are mirror images.
#pragma once

#include <limits>
#include <variant>
#include <vector>

#include "core/types.h"

namespace umax::figure {

constexpr double far_away = std::numeric_limits<double>::max();

/// Smooth minimum with compact support: equals min(a, b) where |a - b| >= blend; twice differentiable.
double smooth_min(double a, double b, double blend);
double smooth_max(double a, double b, double blend);
/// 0 below `low`, 1 above `high`, cubic between; `low` may exceed `high`.
double smooth_step(double low, double high, double x);

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
  Part torso, head, ears, ear_hollows, eyes, eyelids, nose, nostrils, tail;
  Part legs, arms, fingers, toes, claws;
};
Anatomy make_anatomy();

/// Signed distances [m] at a point: of the parts that painting tells apart, and of all together.
struct Distances {
  double skin = far_away;  // everything soft: torso, limbs, head, ears, tail
  double torso = far_away, head = far_away, ears = far_away, ear_hollows = far_away, tail = far_away;
  double legs = far_away, arms = far_away;
  double shell = far_away, cap = far_away, guards = far_away;  // the plates
  double eyes = far_away, eyelids = far_away, nose = far_away, claws = far_away;
  double all = far_away;
};

/// Distances that are right where |all| <= reach; further parts may be left at far_away.
Distances distances(const Anatomy& anatomy, const Vector3d& p, double reach);

/// Where a point lies on the armour: which row and tile, and how far from the tile's edges.
struct PlatePattern {
  double height = 0;  // [m] to add to the plate's thickness
  double groove = 0;  // [0, 1] 1 in the seams between tiles
  double rim = 0;     // [0, 1] 1 at the raised lower edge of a band
};
PlatePattern shell_pattern(const Vector3d& p);
PlatePattern cap_pattern(const Vector3d& p);
PlatePattern tail_pattern(const Vector3d& p);
double shell_distance(double torso, const Vector3d& p);
double cap_distance(double head, const Vector3d& p);
/// [m] to be added to the skin's distance: belly bands, mouth, fine relief. Positive carves.
double skin_relief(const Distances& d, const Vector3d& p);
double mouth_line(const Vector3d& p);  // [0, 1] 1 in the line of the mouth

/// Linear Rec. 709 colour of a point on the surface with outward unit normal n.
Vector3d paint(const Anatomy& anatomy, const Vector3d& p, const Vector3d& n);

}  // namespace umax::figure
