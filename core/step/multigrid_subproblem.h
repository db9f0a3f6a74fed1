// The SQP's subproblem without a Delassus matrix: thousands of contacts beside a matrix K that is never stored.
//
//   dx = K^-1 (J^T f - grad),   w = J dx + ...
//   gap + n.w >= 0  perp  f_n >= 0,   friction in Coulomb's cone
//
// Proximal iterations: the contacts are solved against the multilevel compliance (core/step/bpx_contact_compliance.h)
// instead of J K^-1 J^T. The linear system is then solved on with the change of the forces, from which the compliance
// learns; what a solve leaves over is in the residual of the next, so that the limits' rows hold for the sum of them
// all.
//
// Contacts with obstacles that push are held by springs in the matrix meanwhile (core/step/held_contacts.h): where they go on
// pushing, the first solve finds their forces. Where they are in the way of others, the system is solved without.
//
// Where the iterate's forces are in balance and only limits or contacts miss their tolerance, the right-hand side of
// forces is left out: the step is the least one, in the matrix's norm, that restores them. What is left of forces would
// slide along soft modes and bring other hexes beyond their limits.
#pragma once

#include "core/step/newton_system.h"

namespace umax {

/// Makes the model's multigrids, if they are not there yet.
void prepare_multigrid(const StepProblem& problem, const Iterate& iterate, Workspace::Data& workspace);

/// The subproblem's step from an iterate that has been assessed: its residuals tell how exactly to solve. Contacts that
/// it would push in too deep join the iterate's, and all of them get their forces. Work is added to the report.
NewtonStep minimise_multigrid(const StepProblem& problem, const Linearisation& at, const VectorXd& slope,
                              Iterate& iterate, Workspace::Data& workspace, StepReport& report);

}  // namespace umax
