// The SQP's subproblem without a Delassus matrix: thousands of contacts beside a matrix K that is never stored.
//
//   dx = K^-1 (J^T f - grad),   w = J dx + ...:   gap + n.w >= 0  perp  f_n >= 0,   friction in Coulomb's cone
// Proximal iterations: the contacts are solved against the multilevel compliance (core/multilevel_compliance.h) instead
// of J K^-1 J^T. One linear solve then tells what the whole change of the forces does, which the compliance learns; it
// is scaled so that no iteration overshoots.
#pragma once

#include "core/newton_system.h"

namespace umax {

/// The subproblem's step from the iterate. Contacts that it would push in too deep join the iterate's, and all of them
/// get their impulses.
NewtonStep minimise_subproblem(const StepProblem& problem, const Linearisation& at, const VectorXd& grad,
                               Iterate& iterate, Workspace::Data& workspace, StepReport& report);

}  // namespace umax
