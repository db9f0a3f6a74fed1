// One linearisation of a step on multigrids: for tests of what it is solved by.
#pragma once

#include "core/step/multigrid_subproblem.h"
#include "tests/support/begun_step.h"

namespace umax::test {

struct LinearisedStep : BegunStep {
  Iterate iterate = predict(problem, state);
  Linearisation at;
  StepReport report;

  /// The iterate is evaluated; its contacts are where they were recalled from.
  LinearisedStep(const Model& of, const State& from) : BegunStep(of, from, {.time_step = 0.01}) {
    evaluate(problem, iterate.positions, iterate.evaluation);
    at.limits = limit_terms(problem, iterate, 1e4);
  }
  VectorXd slope() const { return gradient(problem, iterate, at); }
  /// The iterate's residuals tell how exactly.
  NewtonStep minimise() {
    Workspace::Data workspace;
    return minimise_multigrid(problem, at, slope(), iterate, workspace, report);
  }
};

}  // namespace umax::test
