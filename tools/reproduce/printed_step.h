// Sect. 5 of [PPO13] as it is printed, for a model of a single hex: small enough to be written out densely.
//
// Eq. 19       A v* = b,   A = M - h dF/dv - h^2 dF/dx,   b = (M - h dF/dv) v0 + h F
// Eq. 20, 21   v = v* + A^-1 J^T lambda        with the TOTAL lambda, J taken anew at every iteration
// Eq. 22, 23   0 <= lambda  perp  C0/h + J dv >= 0
//
// F(x0, v0) = f_el(x0) - D v0 + M g,   dF/dv = -D,   dF/dx = -K(x0) warped,   D = alpha M + beta K(x0)
#pragma once

#include "core/step/step.h"

namespace umax::printed {

/// A value of every node of the hex, in its order.
Vector24d in_hex_order(const Model& model, const Points& values);

/// v* [m/s] of [PPO13] Eq. 19, nodes in the hex's order; that of fixed nodes is 0.
Vector24d equation_19(const Model& model, const StepOptions& options, const State& state);

/// U/U_max at the end of a step whose limit is enforced by Eq. 21 to 23, started again from v* each time; iterated
/// until it is at most 1 + tolerance or options.solver.max_iterations are spent.
double equation_21_energy_ratio(const Model& model, const StepOptions& options, const State& state);

}  // namespace umax::printed
