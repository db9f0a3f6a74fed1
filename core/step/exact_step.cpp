#include "core/step/exact_step.h"

#include <algorithm>
#include <utility>

#include "core/model/hex_limits.h"
#include "core/problem/body_shares.h"
#include "core/problem/step_length.h"
#include "core/step/augmented_lagrangian.h"
#include "core/step/contact_counts.h"
#include "core/step/direct_subproblem.h"
#include "core/step/multigrid_subproblem.h"

namespace umax {
namespace {

constexpr double relative_penalty = 1e4;   // rho / U_max, where the matrix is factored
constexpr double multigrid_penalty = 1e3;  // rho / (U_max + lambda), on multigrids
constexpr double inertial_penalty = 10;  // [-] stiffness that a penalty gives a hex, at least, over that of its inertia
constexpr double hold = 10;              // [-] of a limit in proportion to what exceeds it: 1 ... 100 do as well
constexpr int normal_updates = 6;        // iterations, but those cut short where bodies meet, after which contacts
                                         // keep their normals
constexpr double worth_patience = 10;  // [tolerances] of the residual, once: two halves cost more than some iterations

// One of the two ways in which the SQP solves its subproblem, and what goes with it.
struct BackEnd {
  void (*prepare)(const StepProblem&, const Iterate&, Workspace::Data&);  // once, before the first subproblem
  NewtonStep (*minimise)(const StepProblem&, const Linearisation&, const VectorXd& slope, Iterate&, Workspace::Data&,
                         StepReport&);
  double (*penalty)(double limit, double multiplier);  // [J] on limits
  int patience, patience_near;  // [max_newton_iterations] of the SQP, the second if it came near the solution
  bool limits_distortion;       // the few hexes that a step distorts too much, instead of holding back all
  bool corrects;                // a step's length by the step before (core/problem/step_length.h)
  bool halves_first;            // a failed step, if it may, before the safety net is tried
};

constexpr BackEnd direct{.prepare = prepare_direct,
                         .minimise = minimise_direct,
                         .penalty = [](double limit, double) { return relative_penalty * limit; },
                         .patience = 1,
                         .patience_near = 2,
                         .limits_distortion = false,
                         .corrects = false,
                         .halves_first = false};

// The penalty is in proportion to the stiffness that the multiplier gives the hex, and violations fall to a thousandth:
// a larger one only makes linear systems harder, as multipliers that alternate along a line of hexes hardly push its
// nodes and grow with it. Without a factor to fall back on, what comes after failure is dear, dearest where little was
// missing, and two halves of the step are cheaper than the safety net. Of so many hexes a few are distorted in most
// steps.
constexpr BackEnd multigrid{
    .prepare = prepare_multigrid,
    .minimise = minimise_multigrid,
    .penalty = [](double limit, double multiplier) { return multigrid_penalty * (limit + multiplier); },
    .patience = 2,
    .patience_near = 3,
    .limits_distortion = true,
    .corrects = true,
    .halves_first = true};

// What the penalty rho [J] must be at least in short steps, where inertia is stiffer than all else: c of
//   rho / U_max^2 G^T (M / h^2)^-1 G = c,   G where U = U_max, as U / G^2 hardly changes
// A violation, and what a multiplier misses, fall to 1 / (1 + c) in an iteration.
double least_penalty(const StepProblem& problem, const Iterate& iterate, Eigen::Index l) {
  const Model& model = *problem.model;
  const auto gradient = iterate.evaluation.limit_gradient(model, l);
  double mobility = 0;  // G^T M^-1 G [J/s^2]
  for (int n = 0; n < 8; ++n) {
    const int node = model.hexes(model.limits[l].hex, n);
    if (!model.node_fixed[node]) mobility += gradient.segment<3>(3 * n).squaredNorm() / model.node_mass[node];
  }
  if (mobility == 0) return 0;
  return inertial_penalty * problem.materials.limits[l] * iterate.evaluation.energy[l] /
         (problem.h * problem.h * mobility);
}

// Terms of the limits that the next iteration holds: not of those whose multiplier came out negative in the one before.
// Energies are convex, so a step to the linearised limit ends a little beyond it, and such a hex would be held there
// for ever. Whether a limit is held must not depend on the penalty: a large one lets go at a hair's breadth below the
// limit.
std::vector<LimitTerms> sequential_limit_terms(const StepProblem& problem, const BackEnd& back_end,
                                               const Iterate& iterate) {
  std::vector<LimitTerms> terms = limit_terms(problem, iterate, relative_penalty);
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l) {
    if (problem.model->limits[l].kind != LimitKind::hard) continue;
    const double energy = iterate.evaluation.energy[l], limit = problem.materials.limits[l],
                 multiplier = iterate.multipliers[l];
    terms[l] = {};
    if (iterate.released[l] || multiplier + hold * (energy - limit) <= 0) continue;
    const double penalty = std::max(back_end.penalty(limit, multiplier), least_penalty(problem, iterate, l));
    terms[l] = held_limit_terms(energy, limit, multiplier, penalty);
  }
  return terms;
}

void update_multipliers(const StepProblem& problem, const Linearisation& at, const VectorXd& change,
                        const VectorXd& shares, Iterate& iterate) {
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l) {
    if (problem.model->limits[l].kind != LimitKind::hard) continue;
    const bool held = at.limits[l].rank_one > 0;
    const double next = problem.materials.limits[l] * (at.limits[l].force + at.limits[l].rank_one * change[l]);
    iterate.released[l] = held && next < 0;
    const double share = shares[problem.model->hex_body[problem.model->limits[l].hex]];
    iterate.multipliers[l] += share * ((held ? std::max(0.0, next) : 0) - iterate.multipliers[l]);
  }
}

bool bodies_touch(const Iterate& iterate) {
  return std::any_of(iterate.contacts.begin(), iterate.contacts.end(),
                     [](const Contact& contact) { return contact.between_bodies(); });
}

// the hybrid SQP; false if it does not reach the solution in its iterations
bool sequential_quadratic(const StepProblem& problem, const BackEnd& back_end, Workspace::Data& workspace,
                          Iterate& iterate, StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  std::vector<TakenStep> last;
  bool been_near = false;
  int cut_steps = 0;  // where bodies come near each other
  for (int iteration = 0;; ++iteration) {
    evaluate(problem, iterate.positions, iterate.evaluation);
    const int added = find_contacts(problem, iteration - cut_steps >= normal_updates, iterate);
    const Quality quality = assess(problem, iterate);
    iterate.residuals.push_back(quality.kkt);
    report_iteration(problem, iteration, quality, iterate);
    if (added == 0 && is_solution(problem, quality, iterate) &&
        (iteration > 0 || is_exact_guess(problem, quality, iterate)))
      return true;
    been_near = been_near || quality.kkt <= worth_patience * solver.tolerance;
    const int patience = been_near ? back_end.patience_near : back_end.patience;
    const int spent = std::max(iteration - cut_steps, iteration / 2);  // cut ones are many where bodies come together
    if (spent >= patience * solver.max_newton_iterations) return false;

    // linearise, and solve for the step with its contacts' forces
    ++report.sqp_iterations;
    const Linearisation at{sequential_limit_terms(problem, back_end, iterate), {}};  // contacts are solved for apart
    NewtonStep newton = back_end.minimise(problem, at, gradient(problem, iterate, at), iterate, workspace, report);
    if (back_end.limits_distortion) limit_distortion(model, newton.step);

    // go along it as far as what is linear holds
    iterate.last_move = largest_move(model, newton.step);
    VectorXd shares = body_shares(problem, iterate, newton.step);
    update_multipliers(problem, at, newton.limit_change, shares, iterate);
    const bool is_cut = shares.minCoeff() < shares.maxCoeff();
    if (!is_cut) {
      const bool balanced = is_balanced(quality.kkt, solver.tolerance);
      shares = step_factors(model, newton.step, shares[0], balanced, iterate.residuals, last);
      // a factor's steps are long enough, but may go to and fro
      shares = back_end.corrects ? as_far_as_felt(problem, iterate, newton.step, shares) : shares.cwiseMin(1.0);
    }
    if (is_cut || (shares.minCoeff() < 1 && bodies_touch(iterate))) ++cut_steps;
    iterate.last_move *= std::max(1.0, shares.maxCoeff());
    last = is_cut || !(back_end.corrects || bodies_touch(iterate)) ? std::vector<TakenStep>{}
                                                                   : taken_steps(model, newton.step, shares);
    scale_bodies(model, shares, newton.step);
    iterate.positions += unflatten(newton.step);
  }
}

// Do pins tear a body at the positions, as far as can be told? Hard limits are passed clearly.
bool is_torn(const StepProblem& problem, const State& state, const Points& positions) {
  constexpr double clearly = 0.01;  // [-] of a limit
  const auto is_exact = [](const PinSpring& spring) { return spring.is_exact; };
  const bool pinned =
      !problem.pins.nodes.empty() || std::any_of(problem.pins.springs.begin(), problem.pins.springs.end(), is_exact);
  if (!state.been_feasible || !pinned) return false;
  const VectorXd ratios = limit_ratios(*problem.model, problem.options->solver, problem.materials, positions);
  for (Eigen::Index l = 0; l < ratios.size(); ++l)
    if (problem.model->limits[l].kind == LimitKind::hard && ratios[l] > 1 + clearly) return true;
  return false;
}

// The SQP; where it fails the safety net; where even that ends beyond the limits, as it may from a crumpled start that
// has a knot for a local minimum, the safety net from the undeformed bodies. The iterate is the best that was found.
StepStatus solve(const StepProblem& problem, bool may_be_halved, Workspace::Data& workspace, const State& state,
                 Iterate& iterate, StepReport& report) {
  iterate = predict(problem, state);
  approach(problem, iterate);
  const BackEnd& back_end = problem.plan.is_multigrid() ? multigrid : direct;
  back_end.prepare(problem, iterate, workspace);
  if (workspace.may_tear && is_torn(problem, state, problem.positions_t0))
    return search_torn(problem, workspace, iterate, report) == Search::solved ? StepStatus::converged
                                                                              : StepStatus::infeasible;
  if (sequential_quadratic(problem, back_end, workspace, iterate, report)) return StepStatus::converged;
  // The safety net has no steps against contacts that turn as bodies move around each other: two halves are cheaper.
  if (may_be_halved && (back_end.halves_first || bodies_touch(iterate))) return StepStatus::iteration_limit;
  iterate = predict(problem, state);
  approach(problem, iterate);
  const Search search = augmented_lagrangian(problem, workspace, iterate, report);
  if (search == Search::solved) return StepStatus::converged;

  iterate.multipliers = state.limit_multipliers;  // those of a violated limit grow for ever: no start for the next step
  if (!state.been_feasible) {
    Iterate undeformed = predict_undeformed(problem, state);
    if (augmented_lagrangian(problem, workspace, undeformed, report) == Search::solved) {
      iterate = std::move(undeformed);
      return StepStatus::converged;
    }
  }
  // halves of a step that pins tear are torn as well
  const bool infeasible =
      search == Search::infeasible || (workspace.may_tear && is_torn(problem, state, iterate.positions));
  return infeasible ? StepStatus::infeasible : StepStatus::iteration_limit;
}

}  // namespace

StepReport exact_step(const StepProblem& problem, bool may_be_halved, Workspace::Data& workspace, State& state) {
  StepReport report;
  Iterate iterate;
  report.status = solve(problem, may_be_halved, workspace, state, iterate, report);
  state.velocities = (iterate.positions - problem.positions_t0) / problem.h;
  state.positions = iterate.positions;
  state.limit_multipliers = iterate.multipliers;
  count_contacts(*problem.model, iterate.contacts, report);
  report.limits_active = count_hexes(*problem.model, limit_factors(problem, iterate));
  report.kkt_residual = iterate.residuals.back();
  remember_contacts(problem, iterate.contacts, state);
  return report;
}

}  // namespace umax
