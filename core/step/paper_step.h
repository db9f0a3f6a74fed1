// The paper's step: constrained velocities, limits and contacts in one projected Gauss-Seidel, re-linearised.
//
// [PPO13] Eq. 19   A v* = b,   A = M + h D + h^2 K(x0),   b = M v0 + h f_el(x0) + h M g,   D = alpha M + beta K(x0)
// [PPO13] Eq. 21   v    = v* + A^-1 J^T lambda
// [PPO13] Eq. 22   J dv >= -C0 / h
// [PPO13] Eq. 23   0 <= lambda  perp  J A^-1 J^T lambda + C0 / h >= 0
//
// v0, v*, v: velocities before, without and with constraints [m/s];  h: time step [s];  M: masses [kg];  g: [m/s^2]
// K: warped stiffness [N/m];  alpha [1/s], beta [s]: damping;  C0: limits and gaps at x0;  J: their derivatives
// Eq. 19 prints b = (M - h dF/dv) v0 + h F: the same, as F holds the damping force -D v0 that -h dF/dv v0 takes out.
// Deviation: re-linearisation adds, v <- v + A^-1 J_k^T lambda_k with lambda_k >= 0 new each time, and every limit that
// was violated once in the step stays a candidate. Starting again from v* with the total lambda diverges as soon as
// lambda / U_max > 1, because A lacks the limits' curvature. Contact forces are totals: they may shrink.
// Deviation: unknowns are forces, lambda / h, as everywhere in this program.
#pragma once

#include "core/problem/step_problem.h"
#include "core/step/workspace.h"

namespace umax {

/// Fills the report's solver fields; positions, velocities, multipliers and contacts of the state are advanced.
StepReport paper_step(const StepProblem& problem, Workspace::Data& workspace, State& state);

}  // namespace umax
