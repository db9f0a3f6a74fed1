// Vertices of bodies' surfaces against the surfaces of other bodies and of far parts of their own.
//
// The touched body's material at a vertex, X (McAdams et al. 2011, Efficient elasticity for character skinning with
// contact and collisions, ACM TOG 30: collisions are found in the undeformed shape), is measured there exactly:
//
// gap    = phi(X) / |F^-T grad phi|
// normal = F^-T grad phi / |F^-T grad phi|
//
// phi: distance from the touched body's rest triangles, negative inside [m];  F: its deformation gradient at X [-]
// The gap is phi to first order in the deformed body, and its derivative is that of the vertex against the material at
// X along the normal: the eight weights of X are the touched body's part of the contact.
//
// The nearest triangle may be on the wrong side of a thin wall, or of a finger smaller than a cell. Where the vertex was
// last outside, seen from the material, is X0 = X + F^-1 (p(a) - x(X, a)), a: the step's start, or
// the last iterate since at which no vertex of its hex was inside that body. If X0 lies outside, only triangles count whose normals are within
// 60 degrees of that of the first one which the path from X0 to X enters; a path that enters the body has entered it even
// where X lies beyond its other side. From one iterate to the next hexes move by no more than half a cell against each
// other (felt_share(), core/contact/encounters.h), so that none passes another unseen.
//
// Hexes that share a node do not touch each other. Surfaces that overlap at rest in the same hexes never do.
#pragma once

#include <vector>

#include "core/contact/contact.h"

namespace umax {

/// Contacts at the positions: for each hex and each body that its vertices may touch, the vertex with the least gap
/// below -share * tolerance_depth. In the order of hexes and touched bodies.
std::vector<Contact> surface_candidates(const ContactStep& step, const LastApart& apart, const Points& positions,
                                        double share);

/// Does the contact keep its plane, since its normal has turned to and fro?
inline bool keeps_plane(const Contact& contact) {
  constexpr int most_turns_back = 1;
  return contact.turns_back > most_turns_back;
}

/// Do the planes of two contacts of one vertex leave no room outside of both, as the two sides of a thin part? The walls of
/// a slot do leave some.
inline bool leave_no_room(const Contact& a, const Contact& b) {
  constexpr double opposed = -0.5;  // [-] cosine of normals: 120 degrees
  return a.normal.dot(b.normal) < opposed && a.gap + b.gap < 0;
}

/// Is a vertex of one body deeper in another than that, or in its own?
bool bodies_meet(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                 bool counts_own);

/// Refreshes place, gap and normal of contacts whose point is a surface's at the positions. One whose vertex has left
/// the touched body's cage, or is in a hex turned inside out, keeps its place and normal. So does one whose normal turns
/// to and fro between iterates, as between two faces at an edge, while it is not well outside: staying outside one face's
/// plane is staying outside of a ridge, and in a groove the other face's joins (add_surface_contacts()). If the vertex is
/// inside, come in by a side that faces the other way, that side's plane takes its place.
void place_surface_contacts(const ContactStep& step, const LastApart& apart, const Points& positions,
                            std::vector<Contact>& contacts);

/// Of a vertex against a body: three hold it in a groove, and where it slides around something round some are left behind.
inline constexpr std::size_t most_planes = 6;

/// Planes of a vertex against a body that have become one are one contact, with the sum of their forces. Where a vertex still
/// has as many planes as it may, the farthest one goes, if it does not push and is out of reach of the tolerance: another that
/// holds the vertex may take its place.
void make_room_for_planes(const Model& model, std::vector<Contact>& contacts);

/// Moves the touched place in the material to where the vertex is now, so that the two bodies' forces have no torque; gap
/// and normal stay.
void keep_at_vertex(const Model& model, const Points& positions, Contact& contact);

}  // namespace umax
