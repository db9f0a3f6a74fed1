// How a contact enters the minimisation of the augmented Lagrangian: what it adds to the potential, the forces and the
// stiffness.
//
// Normal     t = lambda_n - r g                      pushes iff t > 0, then with force t
//            potential  t^2 / (2 r)
// Friction   y = lambda_t - r s                      pulls with y, clipped to the disc |y| <= c
//            potential  |y|^2 / (2 r) inside the disc,  c (|y| - c/2) / r outside
//
// g: gap [m];  s: tangential motion against the obstacle during the step [m];  r: penalty [N/m]
// lambda: the force known so far [N], n and t its normal and tangential parts;  c = friction coefficient x lambda_n [N]
// c stays during a minimisation, so that friction has a potential as well: both are Moreau envelopes.
#pragma once

#include "core/contact/contact.h"
#include "core/contact/gauss_seidel.h"

namespace umax {

struct ContactTerms {
  double energy = 0;                      // [J]
  Vector3d force = Vector3d::Zero();      // [N] on the body
  Matrix3d stiffness = Matrix3d::Zero();  // [N/m] positive semi-definite
};

/// force: known so far [N], world. motion: of the contact point relative to the obstacle during the step [m]. penalty
/// r: [N/m].
inline ContactTerms augmented_contact(const Contact& contact, const Vector3d& force, const Vector3d& motion,
                                      double penalty) {
  ContactTerms terms;
  const Vector3d n = contact.normal;
  const double known = n.dot(force), t = known - penalty * contact.gap;
  if (t > 0) {
    terms.energy = t * t / (2 * penalty);
    terms.force = t * n;
    terms.stiffness = penalty * n * n.transpose();
  }
  const double radius = contact.friction * std::max(0.0, known);
  if (radius > 0) {
    const Matrix3d across = Matrix3d::Identity() - n * n.transpose();
    const Vector3d y = across * (force - penalty * motion);
    const double length = y.norm();
    const Vector3d clipped = project_to_disc(y, radius);
    terms.energy += (clipped.dot(y) - 0.5 * clipped.squaredNorm()) / penalty;
    terms.force += clipped;
    if (length <= radius)
      terms.stiffness += penalty * across;
    else
      terms.stiffness += penalty * radius / length * (across - y * y.transpose() / (length * length));
  }
  return terms;
}

}  // namespace umax
