// How a contact enters the minimisation of the augmented Lagrangian: what it adds to the potential, the forces and the
// stiffness.
//
// With gap g, sliding s (the tangential motion against the obstacle during the step) and the force lambda known so far,
//   normal    t = lambda_n - r g:                      pushes iff t > 0, then with force t
//   friction  y = lambda_t - r s, clipped to a disc:   its radius, friction x lambda_n, stays during a minimisation, so
//                                                      that both have a potential: Moreau's envelopes
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
