#include "core/step/step.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/hex_limits.h"
#include "core/problem/step_problem.h"
#include "core/step/exact_step.h"
#include "core/step/paper_step.h"
#include "core/step/workspace.h"

namespace umax {
namespace {

// kinetic, elastic (true energy, whatever the limit measures) and gravitational energy
void measure_energies(const Model& model, const StepOptions& options, const State& state, StepReport& report) {
  report.kinetic_energy = report.potential_energy = report.elastic_energy = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    report.kinetic_energy += 0.5 * model.node_mass[node] * state.velocities.row(node).squaredNorm();
    report.potential_energy -= model.node_mass[node] * state.positions.row(node).dot(options.gravity.transpose());
  }
  VectorXd elastic(model.num_hexes());
  parallel_blocks(model.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, options.solver.rotation, hex_nodes(model, state.positions, e));
      elastic[e] = elastic_energy(shape.stiffness, young_at(model, e, state.time), hex);
    }
  });
  for (const double energy : elastic) report.elastic_energy += energy;
}

void measure_into(const Model& model, const StepOptions& options, const ContactGeometry& geometry, const State& state,
                  StepReport& report) {
  report.max_energy_ratio = model.num_hexes() ? energy_ratios(model, options.solver, state).maxCoeff() : 0;
  report.max_penetration = max_penetration(model, geometry, state.positions, state.time);
  measure_energies(model, options, state, report);
}

// solver work adds up over the parts of a halved step; the last part tells what is active at its end
StepReport joined(const StepReport& first, const StepReport& second) {
  StepReport sum = second;
  sum.status = std::max(first.status, second.status);
  sum.sqp_iterations += first.sqp_iterations;
  sum.factorisations += first.factorisations;
  sum.linear_iterations += first.linear_iterations;
  sum.retries += first.retries;
  sum.kkt_residual = std::max(first.kkt_residual, second.kkt_residual);
  return sum;
}

// one solve over options.time_step; where it does not converge, two of half the size, and so on
StepReport advance(const Model& model, const StepOptions& options, const LinearPlan& plan, Workspace::Data& data,
                   State& state, int halvings) {
  const State start = state;
  const StepProblem problem = begin_step(model, options, plan, data.contact_geometry, state);
  const bool exact = options.solver.method == SolverMethod::exact;
  const bool may_be_halved = exact && halvings > 0 && start.been_feasible;
  StepReport report = exact ? exact_step(problem, may_be_halved, data, state) : paper_step(problem, data, state);
  state.time = start.time + options.time_step;
  if (!may_be_halved || report.status != StepStatus::iteration_limit) return report;

  state = start;
  StepOptions half = options;
  half.time_step = options.time_step / 2;
  StepReport failed;
  failed.retries = 1;
  failed.sqp_iterations = report.sqp_iterations;
  failed.factorisations = report.factorisations;
  failed.linear_iterations = report.linear_iterations;
  const StepReport first = advance(model, half, plan, data, state, halvings - 1);
  const StepReport second = advance(model, half, plan, data, state, halvings - 1);
  return joined(joined(failed, first), second);
}

}  // namespace

Workspace::Workspace(const Model& model)
    : data_(new Data{make_contact_geometry(model), std::nullopt, SparseCholesky(), std::nullopt}) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;

StepReport step(const Model& model, const StepOptions& options, Workspace& workspace, State& state) {
  require_measurable(model, options.solver.energy);
  const LinearPlan plan = plan_linear_solvers(model, options.solver);
  require_solvable(plan, options.solver);
  State next = state;
  StepReport report = advance(model, options, plan, workspace.data(), next, options.solver.max_halvings);
  next.time = state.time + options.time_step;
  ++next.step;
  measure_into(model, options, workspace.data().contact_geometry, next, report);
  next.been_feasible = next.been_feasible || report.max_energy_ratio <= 1 + options.solver.tolerance;
  if (!next.been_feasible) report.status = StepStatus::infeasible;
  state = std::move(next);
  return report;
}

StepReport measure(const Model& model, const StepOptions& options, const State& state) {
  StepReport report;
  measure_into(model, options, make_contact_geometry(model), state, report);
  return report;
}

VectorXd energy_ratios(const Model& model, const SolverOptions& solver, const State& state) {
  return largest_by_hex(model, limit_ratios(model, solver, materials_at(model, state.time), state.positions));
}

}  // namespace umax
