// The nodes that carry a contact: eight of one hex for a point against an obstacle, eight more where a body is touched.
// That is known here alone.
//
// The contact's motion is that of the point against what it touches, J dx = sum_n w_n dx_n - sum_m v_m dx_m, by the
// weights w of the point and v of the touched place. A force f goes to the nodes as J^T f: the point's body gets f, the
// other one -f. An obstacle has no unknowns.
#pragma once

#include "core/contact/contact.h"

namespace umax {

/// Calls visit(support, sign) for each support: 1 for the point's, -1 for that of a touched body.
template <class Visit>
void for_each_support(const Contact& contact, const Visit& visit) {
  visit(contact.support, 1.0);
  if (contact.between_bodies()) visit(contact.other, -1.0);
}

/// Calls visit(node, weight) for each node that carries the contact, in the order of its hexes; weights of the touched
/// body's nodes are negative. A node may come twice.
template <class Visit>
void for_each_node(const Model& model, const Contact& contact, const Visit& visit) {
  for_each_support(contact, [&](const Support& support, double sign) {
    for (int n = 0; n < 8; ++n) visit(model.hexes(support.hex, n), sign * support.weights[n]);
  });
}

/// J v: how the contact moves where the nodes do by v of 3 #N.
template <class Vector>
Vector3d contact_motion(const Model& model, const Contact& contact, const Eigen::MatrixBase<Vector>& v) {
  Vector3d motion = Vector3d::Zero();
  for_each_node(model, contact, [&](int node, double weight) { motion += weight * v.template segment<3>(3 * node); });
  return motion;
}

/// nodal += J^T f, of 3 #N.
template <class Vector>
void spread(const Model& model, const Contact& contact, const Vector3d& force, Vector&& nodal) {
  for_each_node(model, contact,
                [&](int node, double weight) { nodal.template segment<3>(3 * node) += weight * force; });
}

/// Mass [kg] of the nodes around a point, by its weights.
inline double mass_around(const Model& model, const Support& support) {
  double mass = 0;
  for (int n = 0; n < 8; ++n) mass += support.weights[n] * model.node_mass[model.hexes(support.hex, n)];
  return mass;
}

/// Mass [kg] that a contact's force moves: around the point; of two that touch, the reduced one, m1 m2 / (m1 + m2).
inline double contact_mass(const Model& model, const Contact& contact) {
  const double mass = mass_around(model, contact.support);
  if (!contact.between_bodies()) return mass;
  Support place = contact.other;
  place.weights = place.weights.cwiseMax(0);  // it may be a little outside its hex
  const double other = mass_around(model, place);
  return mass * other / (mass + other);
}

/// tolerance_depth() [m] of a contact: of the body with the smaller cells.
inline double tolerance_depth(const Model& model, const Contact& contact) {
  const double depth = tolerance_depth(model, contact.support.hex);
  return contact.between_bodies() ? std::min(depth, tolerance_depth(model, contact.other.hex)) : depth;
}

/// Where the contact's point is [m], against the place that it touches where a body is touched.
inline Vector3d contact_position(const Model& model, const Points& positions, const Contact& contact) {
  const Vector3d position = embedded_position(model, positions, contact.support);
  return contact.between_bodies() ? Vector3d(position - embedded_position(model, positions, contact.other)) : position;
}

/// Indices of the bodies that the contact pushes; the second one -1 for an obstacle's.
struct ContactBodies {
  int first = 0, second = -1;
};
inline ContactBodies bodies_of(const Model& model, const Contact& contact) {
  return {model.hex_body[contact.support.hex], contact.between_bodies() ? model.hex_body[contact.other.hex] : -1};
}

}  // namespace umax
