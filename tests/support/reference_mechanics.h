// One step's minimisation written a second time, from the definitions and with none of core's laws: what the exact
// method's results are held against. Box hexes, rotation at the centre, true energy, obstacles: the plane y = 0.
//
// U_e = sum_q w_q (lambda/2 tr(eps)^2 + mu eps:eps),  eps = sym(sum_j u_j h_j^T),  u_j = R^T x_j - X_j
// Phi(x) = sum_i m_i (|x_i - x0_i - h v0_i|^2 / 2h^2 + alpha |x_i - x0_i|^2 / 2h - g.x_i) + sum_e U_e + damping
#pragma once

#include <array>
#include <vector>

#include "core/step/step.h"

namespace umax::test {

template <class S>
using NodesOf = Eigen::Matrix<S, 8, 3>;

/// A box-shaped hex at rest and its energy; also a limited part of the energy, with moduli and weights of its own.
struct ReferenceHex {
  NodesOf<double> rest;                      // [m] about the centre
  std::array<NodesOf<double>, 8> gradients;  // [1/m] row j: dN_j/dX at each quadrature point
  NodesOf<double> centre_gradients;          // [1/m]
  std::array<double, 8> weights{};           // [m^3] of the quadrature points
  double lame_lambda = 0, lame_mu = 0;       // [Pa]
  double fibre_young = 0;                    // [Pa] of 1/2 Y (f.eps f)^2
  Vector3d fibre{1, 0, 0};                   // f
};

ReferenceHex make_reference_hex(const Matrix8x3d& nodes, double young, double poisson);

/// What the limit bounds, as the energy of a hex: the whole, the volumetric (lambda = K, mu = 0), the deviatoric
/// (lambda = -2/3 mu) or the fibre's part; a peak with its one point weighing the whole volume.
ReferenceHex limited_part(const ReferenceHex& hex, const Model& model, const HexLimit& limit, double young);

/// U_e [J].
double reference_energy(const ReferenceHex& hex, const NodesOf<double>& x);

/// dU_e/dx [N] by complex steps of the energy.
NodesOf<double> reference_force_by_steps(const ReferenceHex& hex, const NodesOf<double>& x);

/// dU_e/dx [N] by the chain rule, R^T dG = [w]S + dS for the turn w of R: so that a complex step of it is the Hessian.
NodesOf<double> reference_force(const ReferenceHex& hex, const NodesOf<double>& x);

/// d2U_e/dx2 [N/m], node after node, by complex steps of the force.
Matrix24d reference_hessian(const ReferenceHex& hex, const NodesOf<double>& x);

/// R K(Y) R^T v at the positions x [N]: the warped stiffness that damps, as the linear force of the turned velocities.
NodesOf<double> reference_warped_product(const ReferenceHex& hex, const NodesOf<double>& x, const NodesOf<double>& v);

/// One backward Euler step from `before`, as a minimisation.
struct ReferenceStep {
  const Model* model = nullptr;
  Vector3d gravity{0, 0, 0};  // [m/s^2]
  double h = 0;               // [s]
  State before;
  std::vector<ReferenceHex> hexes;
  std::vector<ReferenceHex> limited;  // #L what each limit bounds
  VectorXd limits;                    // #L [J]
  VectorXd alpha, beta;               // #N [1/s], #E [s] damping
};

ReferenceStep make_reference_step(const Model& model, const StepOptions& options, const State& before);

NodesOf<double> nodes_at(const ReferenceStep& step, const Points& positions, Eigen::Index e);

void add_to_nodes(const ReferenceStep& step, Eigen::Index e, const NodesOf<double>& element, Points& sum);

/// x0 + h v0, fixed nodes at x0.
Points predictor(const ReferenceStep& step);

/// Phi(x) [J] without limits and contacts; gravity's part is taken against x0.
double incremental_potential(const ReferenceStep& step, const Points& x);

/// Depth [m] that a surface point may keep: a start in the ground, within the contact tolerance, is left as it is.
double kept_depth(const ReferenceStep& step, Eigen::Index point);

/// Height [m] of a surface point above the ground plane y = 0, and what it may keep.
double ground_gap(const ReferenceStep& step, const Points& x, Eigen::Index point);

/// The forces on the nodes [N] whose sum vanishes at the end of a step; each as a gradient, so that of gravity points
/// up.
struct ReferenceForces {
  Points inertia, gravity, elastic, damping, limit, contact;
  Points sum() const { return inertia + gravity + elastic + damping + limit + contact; }
};

/// From the two states alone. Contacts with obstacles' edges are not known here.
ReferenceForces reference_forces(const ReferenceStep& step, const State& after);

}  // namespace umax::test
