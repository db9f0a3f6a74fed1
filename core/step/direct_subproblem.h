// The SQP's subproblem with a factored matrix: contacts outside of it, by Schur complement.
//
//   dx = -A^-1 grad + A^-1 J^T f,   gap + n.J dx >= 0  perp  f_n >= 0,   friction in Coulomb's cone
// W = J A^-1 J^T, the Delassus operator, is formed, and solved with by projected Gauss-Seidel.
#pragma once

#include "core/step/newton_system.h"

namespace umax {

/// Chooses the order of elimination for a step that begins at the iterate: nodes last that contacts are likely to push,
/// which makes every contact's compliance cheap.
void prepare_direct(const StepProblem& problem, const Iterate& iterate, Workspace::Data& workspace);

/// The subproblem's step from the iterate. Contacts that it would push in too deep join the iterate's, and all of them
/// get their forces. Work is added to the report.
NewtonStep minimise_direct(const StepProblem& problem, const Linearisation& at, const VectorXd& slope, Iterate& iterate,
                           Workspace::Data& workspace, StepReport& report);

}  // namespace umax
