#include "core/step/step.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/contact/moving_obstacle.h"
#include "core/linear/direct/sparse_cholesky.h"
#include "core/model/hex_limits.h"
#include "core/problem/limit_recovery.h"
#include "core/problem/step_problem.h"
#include "core/step/exact_step.h"
#include "core/step/islands.h"
#include "core/step/measurement.h"
#include "core/step/paper_step.h"
#include "core/step/pinned_model.h"
#include "core/step/workspace.h"

namespace umax {
namespace {

constexpr int most_parts = 8;  // of the way of bodies towards each other, half a cell each, in one solve
constexpr int most_fast_halvings = 8;
constexpr double longest_drive =
    0.25;  // [cells] of nodes that pins drive, away from where they are heading, in one solve
constexpr double longest_animated_way = 1;  // [cells] of an animated obstacle near a body in one solve

// solver work adds up over the parts of a halved step; the last part tells what is active at its end
StepReport joined(const StepReport& first, const StepReport& second) {
  StepReport sum = second;
  sum.status = std::max(first.status, second.status);
  sum.sqp_iterations += first.sqp_iterations;
  sum.factorisations += first.factorisations;
  sum.linear_iterations += first.linear_iterations;
  sum.retries += first.retries;
  sum.substeps += first.substeps;
  sum.kkt_residual = std::max(first.kkt_residual, second.kkt_residual);
  return sum;
}

// the work of an attempt that is made again
StepReport tried(const StepReport& attempt) {
  StepReport work;
  work.retries = attempt.retries;
  work.substeps = 0;
  work.sqp_iterations = attempt.sqp_iterations;
  work.factorisations = attempt.factorisations;
  work.linear_iterations = attempt.linear_iterations;
  return work;
}

// Do hexes that may touch come so far towards each other that one solve would have too long a way?
bool moves_too_fast(const Model& model, const ContactGeometry& geometry, const StepOptions& options,
                    const State& state) {
  if (!geometry.touchable.any()) return false;
  const Points expected = state.positions + options.time_step * state.velocities;
  return largest_approaches(model, geometry.touchable, geometry.hex_starts, state.positions, expected).maxCoeff() >
         most_parts;
}

// Does an animated obstacle move so far near a body that it might come through it?
bool obstacles_move_too_fast(const Model& model, const StepOptions& options, const State& state) {
  const auto is_animated = [](const Obstacle& obstacle) { return obstacle.deformation != nullptr; };
  if (std::none_of(model.obstacles.begin(), model.obstacles.end(), is_animated)) return false;
  const Points expected = state.positions + options.time_step * state.velocities;
  return animated_way(model, state.positions, expected, state.time, options.time_step) > longest_animated_way;
}

// Do pins drive nodes so far away from where they would go by themselves that one solve would have too long a way?
bool pins_move_too_fast(const Model& model, const StepOptions& options, const State& state) {
  return farthest_drive(model, state, options.time_step) > longest_drive;
}

// how often a step may still be halved: where it does not converge, and where bodies move too fast
struct Halvings {
  int failed = 0, fast = 0;
};

StepReport advance(const Model& model, const StepOptions& options, const LinearPlan& plan, Workspace::Data& data,
                   State& state, Halvings left);

// two solves over half of options.time_step each
StepReport advance_halves(const Model& model, const StepOptions& options, const LinearPlan& plan, Workspace::Data& data,
                          State& state, Halvings left) {
  StepOptions half = options;
  half.time_step = options.time_step / 2;
  const StepReport first = advance(model, half, plan, data, state, left);
  return joined(first, advance(model, half, plan, data, state, left));
}

// one solve over options.time_step; where it does not converge or bodies move too fast, two of half the size, and so on
StepReport advance(const Model& model, const StepOptions& options, const LinearPlan& plan, Workspace::Data& data,
                   State& state, Halvings left) {
  const bool exact = options.solver.method == SolverMethod::exact;
  if (left.fast > 0 && (obstacles_move_too_fast(model, options, state) || pins_move_too_fast(model, options, state) ||
                        (exact && moves_too_fast(model, data.contact_geometry, options, state))))
    return advance_halves(model, options, plan, data, state, {left.failed, left.fast - 1});
  const State start = state;
  const StepProblem problem =
      begin_step(model, options, plan, data.contact_geometry, state, std::move(data.clearances));
  const bool may_be_halved = exact && left.failed > 0 && start.been_feasible;
  StepReport report = exact ? exact_step(problem, may_be_halved, data, state) : paper_step(problem, data, state);
  state.time = start.time + options.time_step;
  if (problem.contact.deep_start.ways_out.empty()) data.clearances = problem.contact.clearances;
  if (!may_be_halved || report.status != StepStatus::iteration_limit) return report;

  state = start;
  StepReport failed = tried(report);
  ++failed.retries;
  return joined(failed, advance_halves(model, options, plan, data, state, {left.failed - 1, left.fast}));
}

// the reports of two islands as one
StepReport beside(const StepReport& first, const StepReport& second) {
  StepReport sum = second;
  sum.status = std::max(first.status, second.status);
  sum.limits_active += first.limits_active;
  sum.contacts += first.contacts;
  sum.contacts_obstacles += first.contacts_obstacles;
  sum.contacts_between += first.contacts_between;
  sum.contacts_within += first.contacts_within;
  sum.sqp_iterations = std::max(first.sqp_iterations, second.sqp_iterations);
  sum.factorisations = std::max(first.factorisations, second.factorisations);
  sum.linear_iterations += first.linear_iterations;
  sum.retries += first.retries;
  sum.substeps = std::max(first.substeps, second.substeps);
  sum.kkt_residual = std::max(first.kkt_residual, second.kkt_residual);
  return sum;
}

// the island of these bodies, the last step's if it had that one
std::unique_ptr<Island> island_of(const Model& model, const std::vector<int>& bodies, Workspace::Data& data) {
  for (std::unique_ptr<Island>& island : data.islands)
    if (island && island->bodies == bodies) return std::move(island);
  return make_island(model, data.contact_geometry, bodies);
}

StepReport advance_whole(const Model& model, const StepOptions& options, Workspace::Data& data, State& state) {
  return advance(model, options, plan_linear_solvers(model, options.solver), data, state,
                 {options.solver.max_halvings, most_fast_halvings});
}

// the island by itself, with the matrices that its bodies had before
StepReport advance_island(const Model& model, const StepOptions& options, Workspace::Data& data, Island& island,
                          const State& start, State& part) {
  const auto swap_matrices = [&] {
    for (std::size_t i = 0; i < island.bodies.size(); ++i)
      std::swap(data.bodies[island.bodies[i]], island.workspace.bodies[i]);
  };
  part = part_of(model, start, island);
  StepOptions part_options = options;
  part_options.forces = part_of(model, options.forces, island);
  swap_matrices();
  island.workspace.may_tear = data.may_tear;
  const StepReport report = advance_whole(island.model, part_options, island.workspace, part);
  swap_matrices();
  return report;
}

// at_once: where the BLAS lets several threads solve; else one after the other, as who listens to their iterations expects
void for_each_island(std::size_t count, bool at_once, const std::function<void(Eigen::Index)>& visit) {
  if (at_once) return for_each_solve(Eigen::Index(count), visit);
  for (std::size_t i = 0; i < count; ++i) visit(Eigen::Index(i));
}

// Each island by itself, several at a time; where bodies of two have come into each other after all, these once more,
// together. The paper's method has one system for everything.
StepReport advance_islands(const Model& model, const StepOptions& options, Workspace::Data& data, State& state) {
  std::vector<std::vector<int>> islands;
  if (options.solver.method == SolverMethod::exact)
    islands = find_islands(model, data.contact_geometry, options.time_step, state);
  while (islands.size() > 1) {
    std::vector<std::unique_ptr<Island>> made;
    for (const std::vector<int>& bodies : islands) made.push_back(island_of(model, bodies, data));
    data.islands = std::move(made);
    std::vector<StepReport> reports(islands.size());
    std::vector<State> parts(islands.size());
    const auto advance_one = [&](Eigen::Index i) {
      reports[std::size_t(i)] =
          advance_island(model, options, data, *data.islands[std::size_t(i)], state, parts[std::size_t(i)]);
    };
    for_each_island(islands.size(), !options.on_iteration, advance_one);
    State end = state;
    end.time += options.time_step;
    end.contacts.clear();
    for (std::size_t i = 0; i < parts.size(); ++i) put_back(model, *data.islands[i], parts[i], end);
    std::vector<std::vector<int>> joined = join_islands(model, data.contact_geometry, state, end, islands);
    if (joined.size() == islands.size()) {
      state = std::move(end);
      return std::accumulate(reports.begin() + 1, reports.end(), reports.front(), beside);
    }
    islands = std::move(joined);
  }
  data.islands.clear();
  return advance_whole(model, options, data, state);
}

// the hexes that are beyond their hard limits at the state, ascending
std::vector<int> hexes_beyond_limits(const Model& model, const SolverOptions& solver, const State& state) {
  const VectorXd ratios = limit_ratios(model, solver, materials_at(model, state.time), state.positions);
  std::vector<int> hexes;
  for (Eigen::Index l = 0; l < ratios.size(); ++l) {
    const int hex = model.limits[l].hex;
    if (model.limits[l].kind == LimitKind::hard && ratios[l] > 1 + solver.tolerance &&
        (hexes.empty() || hexes.back() != hex))
      hexes.push_back(hex);
  }
  return hexes;
}

std::vector<int> joined(const std::vector<int>& first, const std::vector<int>& second) {
  std::vector<int> both;
  std::set_union(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(both));
  return both;
}

bool has_pins(const Model& model) {
  return std::any_of(model.bodies.begin(), model.bodies.end(),
                     [](const Model::BodyRange& body) { return body.pins != nullptr; });
}

// What a pin that lets go has torn comes back as core/problem/limit_recovery.h says.
bool same_pins_hold(const Model& model, double before, double after) {
  return std::all_of(model.bodies.begin(), model.bodies.end(), [&](const Model::BodyRange& body) {
    return !body.pins || body.pins->active_at(before) == body.pins->active_at(after);
  });
}

// A step of the model that pins drive. Where a limit keeps a point from where a pin has it, the limits of its hex and of those
// around are put aside and the step is made again, and so on, as long as that helps: what a contact keeps away stays. Where
// limits could not be held, all that were passed are put aside: the body gives way evenly, not in a few hexes that are torn
// inside out.
StepReport advance_pinned(const Model& model, const StepOptions& options, Workspace::Data& data, State& state) {
  const double end = state.time + options.time_step;
  const Model& pinned = pinned_model(model, end, data);
  data.may_tear = &pinned != &model && same_pins_hold(model, state.time, end) &&
                  !are_limits_recovering(model, options.solver, state);
  if (&pinned == &model) return advance_islands(model, options, data, state);
  struct Attempt {
    State end;
    StepReport report;
    double farthest = std::numeric_limits<double>::infinity();  // [cells] that a pin's point misses its place by
  } best;
  StepReport before;  // of attempts made again
  before.substeps = 0;
  for (std::vector<int> beaten;;) {
    put_limits_aside(model, beaten, data);
    Attempt now{state, {}};
    now.report = advance_islands(pinned, options, data, now.end);
    const MissedPins missed = missed_pins(pinned, options, now.end.positions, end);
    now.farthest = missed.farthest;
    std::vector<int> more = with_neighbours(model, joined(beaten, missed.hexes));
    if (data.may_tear && now.report.status == StepStatus::infeasible)
      more = joined(more, hexes_beyond_limits(pinned, options.solver, now.end));
    const bool helps = now.farthest < 0.5 * best.farthest;
    if (helps) std::swap(best, now);
    if (missed.hexes.empty() || !helps || more == beaten) break;
    before = joined(before, tried(best.report));
    beaten = std::move(more);
  }
  state = std::move(best.end);
  return joined(before, best.report);
}

}  // namespace

Workspace::Workspace(const Model& model) : data_(std::make_unique<Data>()) {
  data_->contact_geometry = make_contact_geometry(model);
  data_->bodies.resize(model.bodies.size());
}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;

StepReport step(const Model& model, const StepOptions& options, Workspace& workspace, State& state) {
  require_measurable(model, options.solver.energy);
  require_solvable(plan_linear_solvers(model, options.solver), options.solver);
  require_forces(model, options.forces);
  State next = state;
  if (!next.been_feasible && has_pins(model))  // they may tear in the first step
    next.been_feasible = energy_ratios(model, options.solver, state).maxCoeff() <= 1 + options.solver.tolerance;
  StepReport report = advance_pinned(model, options, workspace.data(), next);
  next.time = state.time + options.time_step;
  ++next.step;
  Workspace::Data& data = workspace.data();
  measure_into(model, options, next, data, report);
  next.been_feasible = next.been_feasible || report.max_energy_ratio <= 1 + options.solver.tolerance;
  // pins beat limits, and what they let go has to come back
  const bool is_pinned = &pinned_model(model, next.time, workspace.data()) != &model;
  const bool may_pass = is_pinned || std::any_of(model.bodies.begin(), model.bodies.end(),
                                                 [&](const auto& body) { return is_let_go(body, next.time); });
  if (!next.been_feasible || (may_pass && report.max_energy_ratio > 1 + options.solver.tolerance))
    report.status = StepStatus::infeasible;
  state = std::move(next);
  return report;
}

}  // namespace umax
