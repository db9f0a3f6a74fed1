// All elements at one set of positions: rotations, energies and gradients, and how far that is from the step's
// solution.
#pragma once

#include <vector>

#include "core/problem/step_problem.h"

namespace umax {

using HexColumns = Eigen::Matrix<double, 24, Eigen::Dynamic>;

struct Evaluation {
  std::vector<CorotatedHex> hexes;  // #E, none where no matrix is assembled
  HexColumns elastic;               // [N] dU/dx of the true energy
  HexColumns damping;               // [N] beta K(x0) (x - x0)/h; no columns where nothing damps
  VectorXd internal;                // 3 #N [N] the sum of both at the nodes, and of pins' springs
  HexColumns limit;                 // #L columns [N] dU/dx of limited energies; none where all equal `elastic`
  VectorXd elastic_energy;          // #E [J] true energy
  VectorXd energy;                  // #L [J] of limits

  auto limit_gradient(const Model& model, Eigen::Index l) const {
    return limit.cols() ? limit.col(l) : elastic.col(model.limits[std::size_t(l)].hex);
  }
};

/// Evaluates every hex at the positions.
void evaluate(const StepProblem& problem, const Points& positions, Evaluation& evaluation);

/// Sums element vectors into nodes, in the order of the hexes: 3 #N.
VectorXd gather(const Model& model, const HexColumns& elements);

/// What acts on a node from outside whatever it does [N]: weight and StepOptions::forces.
Vector3d load_at(const StepProblem& problem, Eigen::Index node);

/// M ((x - x0)/h - v0)/h + alpha M (x - x0)/h - M g - f: what inertia, mass damping and load demand [N] at a node, a
/// fixed one too.
Vector3d inertia_at(const StepProblem& problem, const Points& positions, Eigen::Index node);

/// The sum of factors times limits' gradients [N] at a node. factors: #L [-].
Vector3d limits_at(const Model& model, const Evaluation& evaluation, const VectorXd& factors, Eigen::Index node);

/// What a step without limits and contacts minimises [J]: 1/(2 h^2) |x - x0 - h v0|^2_M + damping + elastic energy -
/// (m g + f) . (x - x0) + pins' springs, with damping of mass as alpha/(2 h) |x - x0|^2_M and of stiffness as beta/(2 h) |x - x0|^2_K(x0).
double incremental_potential(const StepProblem& problem, const Evaluation& evaluation, const Points& positions);

/// Per body, the largest max-norm [N] among inertia, elastic, limit, contact and gravity forces, what kkt_residual() is
/// relative to. Forces that would move a node by less than a millionth of a cell count as none.
VectorXd force_scales(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                      const VectorXd& limit_factors, const std::vector<Contact>& contacts);

/// Stationarity of the positions for the exact step: of the body that is worst, the max-norm of the gradient of the
/// Lagrangian over the largest max-norm of its inertia, elastic, limit, contact and gravity terms; contacts by the
/// residual of the cone complementarity, over the smaller of their two bodies' largest. A light body beside a heavy one
/// is thus solved as well. Forces that would move a node by less than a millionth of a cell count as none.
/// limit_factors: #L [-], lambda/U_max of hard limits (or the barrier's slope).
double kkt_residual(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                    const VectorXd& limit_factors, const std::vector<Contact>& contacts);

}  // namespace umax
