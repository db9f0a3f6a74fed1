// The exact step: the minimiser of the incremental potential under energy limits and frictional contact.
//
//   min_x  1/(2 h^2) |x - xt|_M^2 + sum_e U_e(x),    xt = x0 + h v0 + h^2 g
//   s.t.   U_e(x) <= U_max,   gap_i(x) >= 0 with Coulomb's cone
//
// x0, x: node positions before and after [m];  v0: velocities before [m/s];  h: time step [s];  g: gravity [m/s^2]
// M: masses [kg];  U_e: elastic energy of hex e, U_max: its limit [J];  gap_i: of contact i [m]
//
// Hybrid SQP. Limits live in the matrix A: an active element contributes
//   (1 + lambda/U_max) H + rho/U_max^2 G G^T
// H and G those of the energy that each of its limits measures, which keeps the sparsity of the stiffness, so that
// limits cost nothing extra to factor. Contacts stay outside, by Schur complement:
//   dx = -A^-1 grad + A^-1 J^T f
//   gap + n.J dx >= 0  perp  f_n >= 0,   friction in the cone: by projected Gauss-Seidel
// On multigrids limits are rows of a saddle-point system instead, and the Schur complement is never formed
// (core/step/multigrid_subproblem.h), and where a step distorts few hexes too much these are eased
// (core/problem/step_length.h), not all others held back.
//
// Multipliers lambda [J] are force-level, start from the last step's, and are updated with the step:
//   lambda <- max(0, t + rho G.dx/U_max),   t = lambda + rho (U/U_max - 1)
// A limit is held from iteration to iteration until that would be negative. If the exact Hessian leaves A indefinite,
// the warped stiffness stands in for that iteration.
#pragma once

#include "core/problem/step_problem.h"
#include "core/step/workspace.h"

namespace umax {

/// Fills the report's solver fields; on success the state's positions, velocities, multipliers and contacts are
/// advanced. status iteration_limit: the state holds the best that was reached, which comes sooner where the step may
/// be halved then.
StepReport exact_step(const StepProblem& problem, bool may_be_halved, Workspace::Data& workspace, State& state);

}  // namespace umax
