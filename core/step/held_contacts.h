// Contacts that are held to obstacles by springs which are part of the matrix.
//
// The multilevel compliance (core/step/bpx_contact_compliance.h) tells what a contact's force does to a factor of two, among
// limits far worse, and each correction of forces costs a cycle of the multigrid. Of a contact that pushes, and will push after
// the step, no force has to be foretold: a stiff spring R that pulls it to where it belongs bears what it takes. With springs as
// rank-one terms, as limits are, one solve finds the step, the limits' multipliers and these forces at once:
//
//   (A + sum g g^T) dx = J^T p - grad,   g = sqrt(R) J^T d,   force along d:  p.d - R d.w,   w = J dx
// d: a direction in which the contact is held: its normal, and both tangents where it sticks.
//
// Which contacts push and stick is told by what their springs would bear where the iterate is: p - R times the gap, and R times
// the way that the contact has slid. One that slides may bear a little less friction than it could, as far as forces are
// solved; a spring would tear it back to where the step began.
//
// A contact that opens or slides after all is pushed by p against its spring, as far as the compliance foretells; where that
// goes wrong, the subproblem begins anew without springs.
#pragma once

#include <vector>

#include "core/step/newton_system.h"

namespace umax {

/// One direction of one contact.
struct HeldDirection {
  int contact = 0;              // of the iterate's
  Vector3d direction{0, 0, 0};  // d, of length 1
  double stiffness = 0;         // [N/m] R
  double target = 0;            // [m] motion d.w that closes the gap, or leaves the point where it sticks
  int group = 0;                // RankOneTerm::group
};
using HeldContacts = std::vector<HeldDirection>;

/// Of the iterate's contacts with obstacles all that push. Contacts between bodies are not held: a term lives in one hex.
HeldContacts hold_contacts(const StepProblem& problem, const Linearisation& at, const Iterate& iterate);

/// Their springs, in their order.
std::vector<RankOneTerm> spring_terms(const std::vector<Contact>& contacts, const HeldContacts& held);

/// What the springs do to contacts that move like this: forces [N] of motions w [m], both 3 per contact.
VectorXd spring_forces(const HeldContacts& held, const VectorXd& motions);

/// The motions [m] that bring held contacts to their targets, 0 of others: 3 for each of so many contacts.
VectorXd target_motions(const HeldContacts& held, std::size_t num_contacts);

}  // namespace umax
