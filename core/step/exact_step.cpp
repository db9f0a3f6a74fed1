#include "core/step/exact_step.h"

#include <algorithm>
#include <cmath>

#include "core/contact/gauss_seidel.h"
#include "core/model/hex_limits.h"
#include "core/problem/step_length.h"
#include "core/step/augmented_lagrangian.h"
#include "core/step/delassus.h"
#include "core/step/multigrid_subproblem.h"
#include "core/step/newton_system.h"

namespace umax {
namespace {

constexpr double relative_penalty = 1e4;      // rho / U_max, where the matrix is factored
constexpr double multigrid_penalty = 1e3;     // rho / (U_max + lambda), on multigrids
constexpr double hold = 10;                   // [-] of a limit in proportion to what exceeds it: 1 ... 100 do as well
constexpr int max_contact_rounds = 10;        // detections per factorisation
constexpr int reordering_nodes = 1500;        // of a cage: fewer are not worth it
constexpr double reordering_margin = 1;       // [cells]
constexpr double most_reordered_share = 0.2;  // of the nodes, and no more than
constexpr double most_reordered = 800;        // nodes: their part of the factor is dense
constexpr int normal_updates = 6;             // iterations after which contacts keep their normals

// displacement-level contact problem at the iterate: unknowns are forces [N], w the motion relative to the obstacle [m]
ComplementarityProblem contact_problem(const StepProblem& problem, const Iterate& iterate, const VectorXd& free_step,
                                       const MatrixXd& W) {
  ComplementarityProblem contact;
  contact.q.resize(W.rows());
  const Points moved = iterate.positions - problem.positions_t0;
  const Points step = unflatten(free_step);
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
    const Contact& c = iterate.contacts[i];
    const Vector3d relative = embedded_position(*problem.model, moved, c.hex, c.weights) - c.obstacle_motion;
    contact.q.segment<3>(3 * Eigen::Index(i)) = relative + embedded_position(*problem.model, step, c.hex, c.weights);
    contact.contacts.push_back({c.normal, c.friction, c.gap - c.normal.dot(relative)});
  }
  contact.W = W;
  return contact;
}

// dx = -A^-1 grad + A^-1 J^T f; vertices that dx would push in too deep join the working set against the same factor
VectorXd solve_step(const StepProblem& problem, const SparseCholesky& cholesky, const VectorXd& grad, Iterate& iterate,
                    StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  VectorXd free_step = -grad;
  cholesky.solve(free_step);
  VectorXd step = free_step;
  Delassus delassus;
  for (int round = 0; round < max_contact_rounds; ++round) {
    extend(model, cholesky, iterate.contacts, delassus);
    if (!iterate.contacts.empty()) {
      VectorXd force(3 * Eigen::Index(iterate.contacts.size()));
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
        force.segment<3>(3 * Eigen::Index(i)) = iterate.contacts[i].impulse / problem.h;
      report.linear_iterations +=
          gauss_seidel(contact_problem(problem, iterate, free_step, delassus.W),
                       {.max_sweeps = solver.max_sweeps, .tolerance = std::min(1e-6, 1e-2 * solver.tolerance)}, force)
              .sweeps;
      VectorXd push = VectorXd::Zero(step.size());
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
        iterate.contacts[i].impulse = problem.h * force.segment<3>(3 * Eigen::Index(i));
        spread(model, iterate.contacts[i], force.segment<3>(3 * Eigen::Index(i)), push);
      }
      clear_fixed(model, push);
      cholesky.solve(push);
      step = free_step + push;
    }
    if (add_linearised_contacts(problem, step, iterate) == 0) break;
  }
  return step;
}

// G . step of the limits that are active [J]
VectorXd limit_change(const StepProblem& problem, const Linearisation& at, const VectorXd& step,
                      const Iterate& iterate) {
  const Model& model = *problem.model;
  VectorXd change = VectorXd::Zero(problem.limits.size());
  for (Eigen::Index l = 0; l < problem.limits.size(); ++l)
    if (at.limits[l].rank_one > 0)
      for (int n = 0; n < 8; ++n)
        change[l] += iterate.evaluation.limit_gradient(model, l).segment<3>(3 * n).dot(
            step.segment<3>(3 * model.hexes(model.limits[l].hex, n)));
  return change;
}

// Terms of the limits that the next iteration holds: not of those whose multiplier came out negative in the one before.
// Energies are convex, so a step to the linearised limit ends a little beyond it, and such a hex would be held there
// for ever. Whether a limit is held must not depend on the penalty: a large one lets go at a hair's breadth below the
// limit.
// On multigrids the penalty is in proportion to the stiffness that the multiplier gives the hex, and violations fall to
// a thousandth: a larger one only makes linear systems harder, as multipliers that alternate along a line of hexes
// hardly push its nodes and grow with it.
std::vector<LimitTerms> sequential_limit_terms(const StepProblem& problem, bool multigrid, const Iterate& iterate) {
  std::vector<LimitTerms> terms = limit_terms(problem, iterate, relative_penalty);
  for (Eigen::Index l = 0; l < problem.limits.size(); ++l) {
    if (problem.model->limits[l].kind != LimitKind::hard) continue;
    const double energy = iterate.evaluation.energy[l], limit = problem.limits[l], multiplier = iterate.multipliers[l];
    const bool held = !iterate.released[l] && multiplier + hold * (energy - limit) > 0;
    const double penalty = multigrid ? multigrid_penalty * (limit + multiplier) : relative_penalty * limit;
    terms[l] = held ? held_limit_terms(energy, limit, multiplier, penalty) : LimitTerms{};
  }
  return terms;
}

void update_multipliers(const StepProblem& problem, const Linearisation& at, const VectorXd& change, double share,
                        Iterate& iterate) {
  for (Eigen::Index l = 0; l < problem.limits.size(); ++l) {
    if (problem.model->limits[l].kind != LimitKind::hard) continue;
    const bool held = at.limits[l].rank_one > 0;
    const double next = problem.limits[l] * (at.limits[l].force + at.limits[l].rank_one * change[l]);
    iterate.released[l] = held && next < 0;
    iterate.multipliers[l] += share * ((held ? std::max(0.0, next) : 0) - iterate.multipliers[l]);
  }
}

// Nodes that contacts of this step are likely to push: eliminated last, they make every contact's compliance cheap.
// None in small cages, where analysing the pattern for each new set costs more, nor where there are too many.
std::vector<int> nodes_near_obstacles(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  std::vector<int> nodes;
  if (model.num_nodes() < reordering_nodes) return nodes;
  std::vector<char> near(model.num_nodes(), 0);
  for (const int hex : hexes_near_obstacles(problem.contact, iterate.positions, reordering_margin))
    for (int n = 0; n < 8; ++n) near[model.hexes(hex, n)] = 1;
  for (const Contact& contact : iterate.contacts)
    for (int n = 0; n < 8; ++n) near[model.hexes(contact.hex, n)] = 1;
  for (int node = 0; node < int(near.size()); ++node)
    if (near[node]) nodes.push_back(node);
  if (double(nodes.size()) > std::min(most_reordered, most_reordered_share * double(model.num_nodes()))) nodes.clear();
  return nodes;
}

// the hybrid SQP; false if it does not reach the solution in its iterations
bool sequential_quadratic(const StepProblem& problem, Workspace::Data& workspace, Iterate& iterate,
                          StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const bool multigrid = problem.plan.is_multigrid();
  // what comes after failure is dearer without a factor, dearest where little was missing
  const int most = multigrid ? 2 * solver.max_newton_iterations : solver.max_newton_iterations;
  const int most_near = multigrid ? 3 * solver.max_newton_iterations : most;
  TakenStep last;                 // of multigrids
  std::vector<double> residuals;  // KKT, of each iterate
  bool been_near = false;
  while (true) {
    evaluate(problem, iterate.positions, iterate.evaluation);
    if (report.sqp_iterations < normal_updates)
      update_contacts(problem.contact, iterate.positions, iterate.contacts);
    else
      follow_contacts(problem.contact, iterate.positions, iterate.contacts);
    const int added = add_contacts(problem.contact, iterate.positions, problem.joining_share, iterate.contacts);
    const Quality quality = assess(problem, iterate);
    iterate.kkt_fall = report.sqp_iterations > 0 ? quality.kkt / report.kkt_residual : 1;
    report.kkt_residual = quality.kkt;
    residuals.push_back(quality.kkt);
    tell(problem, report.sqp_iterations, quality, iterate);
    if (added == 0 && is_solution(problem, quality, iterate)) return true;
    been_near = been_near || quality.kkt <= near_solution * solver.tolerance;
    if (report.sqp_iterations >= (been_near ? most_near : most)) return false;
    ++report.sqp_iterations;
    const Linearisation at{sequential_limit_terms(problem, multigrid, iterate), {}};  // contacts are solved for apart
    NewtonStep newton;
    if (multigrid) {
      newton = minimise_subproblem(problem, at, gradient(problem, iterate, at), iterate, workspace, report);
      ease(model, newton.step);  // of so many hexes a few are distorted in most steps
    } else {
      report.factorisations += factorize(problem, at, iterate, workspace);
      newton.step = solve_step(problem, workspace.cholesky, gradient(problem, iterate, at), iterate, report);
      newton.limit_change = limit_change(problem, at, newton.step, iterate);
    }
    iterate.last_move = largest_move(model, newton.step);
    const double share = bearable_share(model, newton.step);
    update_multipliers(problem, at, newton.limit_change, share, iterate);
    const bool balanced = is_balanced(quality.kkt, solver.tolerance);
    const double moved = step_factor(model, newton.step, share, balanced, residuals, last);
    iterate.positions += moved * unflatten(newton.step);
    iterate.last_move *= std::max(1.0, moved);
    last = multigrid ? taken_step(std::move(newton.step), moved) : TakenStep{};
  }
}

// The SQP; where it fails the safety net; where even that ends beyond the limits, as it may from a crumpled start that
// has a knot for a local minimum, the safety net from the undeformed bodies. The iterate is the best that was found.
StepStatus solve(const StepProblem& problem, Workspace::Data& workspace, const State& state, Iterate& iterate,
                 StepReport& report) {
  iterate = predict(problem, state);
  const bool multigrid = problem.plan.is_multigrid();
  if (!multigrid) eliminate_last(*problem.model, nodes_near_obstacles(problem, iterate), workspace);
  if (sequential_quadratic(problem, workspace, iterate, report)) return StepStatus::converged;
  // without a factor to fall back on, two halves of the step are cheaper than the safety net
  if (multigrid && !problem.last_attempt) return StepStatus::iteration_limit;
  iterate = predict(problem, state);
  const Search search = augmented_lagrangian(problem, workspace, iterate, report);
  if (search == Search::solved) return StepStatus::converged;

  const double kkt_residual = report.kkt_residual;
  iterate.multipliers = state.limit_multipliers;  // those of a violated limit grow for ever: no start for the next step
  if (!state.been_feasible) {
    Iterate undeformed = predict_undeformed(problem, state);
    if (augmented_lagrangian(problem, workspace, undeformed, report) == Search::solved) {
      iterate = std::move(undeformed);
      return StepStatus::converged;
    }
  }
  report.kkt_residual = kkt_residual;
  return search == Search::infeasible ? StepStatus::infeasible : StepStatus::iteration_limit;
}

}  // namespace

StepReport exact_step(const StepProblem& problem, Workspace::Data& workspace, State& state) {
  StepReport report;
  Iterate iterate;
  report.status = solve(problem, workspace, state, iterate, report);
  state.velocities = (iterate.positions - problem.positions_t0) / problem.h;
  state.positions = iterate.positions;
  state.limit_multipliers = iterate.multipliers;
  report.contacts = int(iterate.contacts.size());
  report.limits_active = count_hexes(*problem.model, limit_factors(problem, iterate));
  remember_contacts(iterate.contacts, state);
  return report;
}

}  // namespace umax
