// A surface vertex seen from the material of a body's hex that holds it, and what it meets there: gap, normal, and on which
// side of thin walls it belongs (core/contact/surface_contact.h).
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "core/contact/contact.h"
#include "core/contact/material_point.h"

namespace umax {

/// A vertex seen from the material of the hex that it is in.
struct HeldVertex {
  Support vertex, other;
  Matrix3d F_inverse;
  Vector3d X, X0;         // [m] in the frame of the rest surface; X0: where it was last outside
  DistanceBounds bounds;  // [m] of the distance at X
  double moved = 0;       // [m] from X0 to X
};

/// What the vertex meets there.
struct Touch {
  double gap = 0;  // [m]
  Vector3d normal = Vector3d::UnitY();
  double clear = 0;  // [m] at rest: the vertex is outside by that, and has not come through; -infinity: it is not
};

/// [penetration tolerances] of a vertex that counts as outside what it touches.
inline constexpr double nearly_outside = 10;

/// The smaller tolerance_depth() [m] of two hexes.
inline double tolerance_between(const Model& model, int hex, int other_hex) {
  return std::min(tolerance_depth(model, hex), tolerance_depth(model, other_hex));
}

/// The vertex as the other hex sees it; false where that does not hold it. apart: #N x 3 [m] where it was last outside. reach:
/// as in find_material(). position: [m] of the vertex, at which the hex has these maps.
bool hold(const Model& model, const Points& apart, const Support& vertex, const Vector3d& position,
          const HexMaps& other, double reach, HeldVertex& held);

/// The same where the hex has material at the local coordinates s (has_material()).
HeldVertex hold_at(const Model& model, const Points& apart, const Support& vertex, const HexMaps& other,
                   const Vector3d& s);

/// The same by the first of the hexes, at the positions (#N x 3 [m]), that holds it.
bool hold_any(const Model& model, const Points& apart, const Points& positions, const Support& vertex,
              const Vector3d& position, const std::vector<int>& hexes, HeldVertex& held);

/// Hexes of a body that may hold a vertex of the hex at the position, ascending. boxes: of the trees' nodes (boxes_at()).
std::vector<int> hexes_at(const ContactStep& step, const std::vector<std::vector<Eigen::AlignedBox3d>>& boxes, int hex,
                          int body, const Vector3d& position);

/// Is the vertex outside, and nowhere on its way from X0 near enough to the surface to have come through it?
bool is_clear(const ScaledSurface& surface, const HeldVertex& held);

/// No gap that measure() finds without a way out is below this [m]: what the vertex came through is no farther than where
/// it came from.
double least_gap(const HeldVertex& held);

/// Two bodies that start the step deep inside each other.
struct Leaving {
  WayOut way;
  const ContactStep* step = nullptr;
};

/// leaving: which way vertices that started deep have to go. The gap is then that of a plane across the way, which lies as
/// far ahead of where the vertex started as it started deep; vertices nearby that started outside may come in.
Touch measure(const Model& model, const HeldVertex& held, const std::optional<Leaving>& leaving);

/// The depth that the vertex may have at the end of the step, by how deep in the body it was at its start: in whichever hex
/// held it then.
AllowedDepth allowance(const ContactStep& step, const HeldVertex& held);

/// Of vertices of one hex out of the other's body, if the bodies start the step deep inside each other. As long as the step
/// lives.
std::optional<Leaving> leaving_of(const ContactStep& step, int hex, int other_hex);

}  // namespace umax
