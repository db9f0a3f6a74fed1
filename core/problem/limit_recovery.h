// Limits of bodies that pins have torn and let go.
//
// What pins stretch beyond a limit would have to be within it one step after they let go: the body would shrink to a third of
// its length in a sixtieth of a second, and fly off with the energy of that. Its own elasticity brings it back; a limit only
// keeps it from being stretched further, and comes back, where elasticity does not suffice, at no more than half the rest
// length a second:
//
//   U_max' = max(U_max, (sqrt(U / U_max) - 0.5 h / s)^2 U_max)        s: stretch at U_max
//
// While a hex is beyond its limit steps are `infeasible`.
#pragma once

#include "core/problem/step_problem.h"

namespace umax {

/// Whether pins have let go of the body at the time [s]: all that held it, or all but one, less than two seconds ago.
bool is_let_go(const Model::BodyRange& body, double time);

/// Limits [J] #L for a step of h [s] from the state, where those given hold at its end: larger ones in bodies that have been let
/// go, in hexes that are beyond theirs. None is larger unless hard limits have held before (State::been_feasible).
VectorXd recovering_limits(const Model& model, const SolverOptions& solver, const State& state, double h,
                           const Materials& at_end);

/// Whether there is such a hex, at the state's time.
bool are_limits_recovering(const Model& model, const SolverOptions& solver, const State& state);

}  // namespace umax
