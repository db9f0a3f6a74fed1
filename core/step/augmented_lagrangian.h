// The exact method's safety net: an augmented Lagrangian, minimised by Newton steps with a line search.
// docs/solvers.md, Augmented Lagrangian
//
//   L(x) = inertia + damping + elasticity + gravity  +  sum over limits and contacts of their augmented terms
//
// With the multipliers held, L falls at every accepted step, whatever the start; between minimisations the multipliers
// take over what the penalties hold. Slower than the SQP, and does not cycle.
#pragma once

#include "core/problem/iterate.h"
#include "core/step/workspace.h"

namespace umax {

enum class Search {
  solved,
  unfinished,  // SolverOptions::max_augmented_iterations did not suffice
  infeasible,  // ever larger multipliers no longer reduce the violation: no neighbouring state obeys all constraints
};

/// Improves the iterate until it is the step's solution. Work is added to the report.
Search augmented_lagrangian(const StepProblem& problem, Workspace::Data& workspace, Iterate& iterate,
                            StepReport& report);

/// The same where pins have torn a body in the step before: from no multipliers, and where limits are passed clearly once L
/// has been minimised, or in the end, `infeasible` with that minimum, which is what penalties of one size make of what pins
/// and limits want. The potential is the same one in each such step, so that energy falls while pins stand still.
Search search_torn(const StepProblem& problem, Workspace::Data& workspace, Iterate& iterate, StepReport& report);

}  // namespace umax
