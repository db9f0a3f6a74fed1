// Contacts of bodies that give way as their Delassus matrices say, and the motions that forces make: what sweeps
// (core/step/contact_forces.h) and Newton steps (core/step/contact_newton.h) go on from.
#pragma once

#include <vector>

#include "core/step/delassus.h"

namespace umax {

/// Forces and the motions that they make, at the points of each body.
struct ContactState {
  VectorXd forces;                // 3 #C [N]
  std::vector<VectorXd> motions;  // per body, 3 #P [m]
};

/// Holds forces near others: a contact gives way by what its force is off its centre, times `weight` of its own compliance.
struct ProximalTerm {
  VectorXd centre;    // 3 #C [N]
  double weight = 0;  // [-] 0: forces are free
};

/// q: 3 #C [m] motions without forces.
struct ContactProblem {
  const Delassus& delassus;
  const std::vector<ContactRow>& contacts;
  const VectorXd& q;
  ProximalTerm proximal;
  std::vector<double> gives;                // [m/N] by the proximal term, per contact
  std::vector<ContactBlock> blocks;         // with these
  std::vector<VectorXd> free_motions = {};  // without forces
  int count() const { return int(contacts.size()); }
};

/// The problem; as long as what it refers to.
ContactProblem make_contact_problem(const Delassus& delassus, const std::vector<ContactRow>& contacts,
                                    const VectorXd& q, ProximalTerm proximal);

/// The motions of all points under the forces as bodies give way, with the q of contacts at their first points.
std::vector<VectorXd> motions_of(const ContactProblem& problem, const VectorXd& forces);

/// Of one contact, as it gives way by the proximal term, too [m].
Vector3d motion_of(const ContactProblem& problem, const ContactState& state, int contact);

/// Adds a contact's change of its force, and the force, to those of its bodies.
void count_change(const ContactProblem& problem, int contact, const Vector3d& change, const Vector3d& force,
                  ForceChanges& changes);

/// What is left to change at each contact, were it alone [-].
double what_is_left(const ContactProblem& problem, const ContactState& state);

}  // namespace umax
