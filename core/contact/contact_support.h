// The nodes that carry a contact. That these are eight, of one hex of one body, is known here alone.
//
// A contact point moves as the weighted sum of its nodes does, J dx = sum_n w_n dx_n, and spreads a force f to them as
// J^T f: w_n f for node n. The obstacle has no unknowns.
#pragma once

#include "core/contact/contact.h"

namespace umax {

/// Calls visit(node, weight) for each node that carries the contact, in the order of its hex.
template <class Visit>
void for_each_node(const Model& model, const Contact& contact, const Visit& visit) {
  const Support& support = contact.support;
  for (int n = 0; n < 8; ++n) visit(model.hexes(support.hex, n), support.weights[n]);
}

/// J v: how the contact point moves where the nodes do by v of 3 #N.
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

/// Mass [kg] of the nodes around the contact point, by its weights.
inline double contact_mass(const Model& model, const Contact& contact) {
  double mass = 0;
  for_each_node(model, contact, [&](int node, double weight) { mass += weight * model.node_mass[node]; });
  return mass;
}

/// tolerance_depth() [m] of a contact.
inline double tolerance_depth(const Model& model, const Contact& contact) {
  return tolerance_depth(model, contact.support.hex);
}

/// The only support that has unknowns, for what is arranged by hexes: element matrices, their terms, grids.
inline const Support& support_of(const Contact& contact) {
  return contact.support;
}

/// Index of the body that is touched.
inline int body_of(const Model& model, const Contact& contact) {
  return model.hex_body[contact.support.hex];
}

}  // namespace umax
