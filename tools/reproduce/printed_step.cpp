#include "tools/reproduce/printed_step.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>

namespace umax::printed {
namespace {

struct SingleHexSystem {
  Eigen::LLT<Matrix24d> A;
  Vector24d b;
};

void clear_fixed(const Model& model, Vector24d& v) {
  for (int n = 0; n < 8; ++n)
    if (model.node_fixed[model.hexes(0, n)]) v.segment<3>(3 * n).setZero();
}

// [PPO13] Eq. 19
SingleHexSystem assemble(const Model& model, const StepOptions& options, const State& state) {
  assert(model.num_hexes() == 1);
  const HexShape& shape = model.shapes[model.hex_shape[0]];
  const MaterialOptions& material = model.bodies[0].material;
  const double h = options.time_step, young = young_at(model, 0, state.time + h);
  const CorotatedHex hex = corotate(shape, options.solver.rotation, hex_nodes(model, state.positions, 0));
  const Vector24d v0 = in_hex_order(model, state.velocities);

  // M, K, D and F
  Vector24d mass, weight;
  for (int n = 0; n < 8; ++n) {
    mass.segment<3>(3 * n).setConstant(model.node_mass[model.hexes(0, n)]);
    weight.segment<3>(3 * n) = mass[3 * n] * options.gravity;
  }
  const Matrix24d M = mass.asDiagonal(), K = warped_hessian(shape.stiffness, young, hex);
  const Matrix24d D = material.damping_mass.at(0) * M + material.damping_stiffness.at(0) * K;
  const Vector24d F = weight - warped_gradient(shape.stiffness, young, hex) - D * v0;

  Matrix24d A = M + h * D + h * h * K;
  Vector24d b = (M + h * D) * v0 + h * F;
  for (int n = 0; n < 8; ++n) {
    if (!model.node_fixed[model.hexes(0, n)]) continue;
    A.middleRows<3>(3 * n).setZero();
    A.middleCols<3>(3 * n).setZero();
    A.block<3, 3>(3 * n, 3 * n).setIdentity();
  }
  clear_fixed(model, b);
  return {Eigen::LLT<Matrix24d>(A), b};
}

}  // namespace

Vector24d in_hex_order(const Model& model, const Points& values) {
  const Matrix8x3d nodes = hex_nodes(model, values, 0);
  return Eigen::Map<const Vector24d>(nodes.data());
}

Vector24d equation_19(const Model& model, const StepOptions& options, const State& state) {
  const SingleHexSystem system = assemble(model, options, state);
  return system.A.solve(system.b);
}

double equation_21_energy_ratio(const Model& model, const StepOptions& options, const State& state) {
  const SingleHexSystem system = assemble(model, options, state);
  const SolverOptions& solver = options.solver;
  const HexShape& shape = model.shapes[model.hex_shape[0]];
  const double h = options.time_step, end = state.time + h;
  const double young = young_at(model, 0, end), limit = energy_limit_at(model, 0, end);
  const Vector24d x0 = in_hex_order(model, state.positions), unconstrained = system.A.solve(system.b);
  Vector24d v = unconstrained;
  for (int iteration = 0;; ++iteration) {
    // C0 and J at x0 + h v
    const Vector24d x = x0 + h * v;
    const CorotatedHex hex = corotate(shape, solver.rotation, Eigen::Map<const Matrix8x3d>(x.data()));
    const double C = energy_limit_value(shape, solver.energy, young, limit, hex);
    if (-C <= solver.tolerance || iteration == solver.max_iterations) return 1 - C;
    Vector24d J = energy_limit_jacobian(shape, solver.energy, solver.jacobian, solver.rotation, young, limit, hex);
    clear_fixed(model, J);

    // one limit: Eq. 23 is solved by a division
    const Vector24d response = system.A.solve(J);
    const double lambda = std::max(0.0, -(C / h + J.dot(unconstrained - v)) / J.dot(response));
    v = unconstrained + lambda * response;
  }
}

}  // namespace umax::printed
