#include "core/step/augmented_lagrangian.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/problem/body_shares.h"
#include "core/problem/step_length.h"
#include "core/step/newton_system.h"

namespace umax {
namespace {

constexpr double relative_penalty = 1e3;  // rho / U_max
constexpr int max_inner_iterations = 12;  // factorisations between updates of the multipliers
constexpr int max_backtracks = 25;
constexpr double sufficient_decrease = 1e-4;  // of what the slope promises
constexpr double clear_violation = 0.01;      // of a limit, or of a penetration ten tolerances deep
constexpr double falling = 0.95;              // by which share an update must reduce the violation
constexpr int stalled_updates = 4;            // that did not
constexpr double torn = 1;                    // [-] beyond a limit after a minimisation: no multiplier brings that back
constexpr int max_torn_iterations = 60;       // factorisations of a step in which pins tear
constexpr double inner_accuracy = 1e-4;       // of the linear solver, where it is not direct
constexpr double inner_tolerance = 0.1;       // of the solver's, on the gradient

Linearisation linearise(const StepProblem& problem, const Iterate& iterate) {
  Linearisation at;
  at.limits = limit_terms(problem, iterate, relative_penalty);
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l)
    if (problem.model->limits[l].kind == LimitKind::hard) at.limits[l].stiffening = at.limits[l].force;  // L's own
  for (const Contact& contact : iterate.contacts)
    at.contacts.push_back(augmented_contact(contact, contact.force,
                                            relative_motion(problem, iterate.positions, contact),
                                            contact_penalty(problem, contact)));
  return at;
}

double lagrangian(const StepProblem& problem, const Iterate& iterate, const Linearisation& at) {
  double sum = incremental_potential(problem, iterate.evaluation, iterate.positions);
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l) {
    const double energy = iterate.evaluation.energy[l], limit = problem.materials.limits[l];
    sum += problem.model->limits[l].kind == LimitKind::hard
               ? hard_limit_energy(energy, limit, iterate.multipliers[l], relative_penalty * limit)
               : soft_limit_energy(energy, limit, {});
  }
  for (const ContactTerms& terms : at.contacts) sum += terms.energy;
  return sum;
}

// the iterate moved by a step, contacts along the normals that they have
void move(const StepProblem& problem, const VectorXd& step, Iterate& iterate) {
  iterate.positions += unflatten(step);
  iterate.last_move = largest_move(*problem.model, step);
  evaluate(problem, iterate.positions, iterate.evaluation);
  follow_contacts(problem.contact, iterate.positions, iterate.contacts);
}

// moves the iterate along the step as far as L falls by a share of what its slope promises; false: nowhere
bool descend(const StepProblem& problem, const VectorXd& step, double promised, double before, Iterate& iterate) {
  double share = 1;
  for (int backtracks = 0; backtracks < max_backtracks; ++backtracks, share *= 0.5) {
    Iterate trial = iterate;
    move(problem, share * step, trial);
    if (lagrangian(problem, trial, linearise(problem, trial)) > before + sufficient_decrease * share * promised)
      continue;
    iterate = std::move(trial);
    return true;
  }
  return false;
}

// is no component of the slope larger than what its body bears?
bool is_flat(const Model& model, const VectorXd& slope, const VectorXd& bearable) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Model::BodyRange& body = model.bodies[b];
    if (slope.segment(3 * body.first_node, 3 * body.num_nodes).cwiseAbs().maxCoeff() > bearable[Eigen::Index(b)])
      return false;
  }
  return true;
}

struct Minimisation {
  bool settled = false;  // as low as the multipliers are worth
  int iterations = 0;
};

// Newton's method on L with the multipliers held
Minimisation minimise(const StepProblem& problem, Workspace::Data& workspace, int budget, Iterate& iterate,
                      StepReport& report) {
  const int most = std::min(budget, max_inner_iterations);
  for (int i = 0; i < most; ++i) {
    const Linearisation at = linearise(problem, iterate);
    const VectorXd slope = gradient(problem, iterate, at);
    VectorXd forces(problem.materials.limits.size());
    for (Eigen::Index l = 0; l < forces.size(); ++l) forces[l] = at.limits[l].force;
    const VectorXd scales = force_scales(problem, iterate.evaluation, iterate.positions, forces, iterate.contacts);
    if (i > 0 && is_flat(*problem.model, slope, inner_tolerance * problem.options->solver.tolerance * scales))
      return {true, i};

    ++report.sqp_iterations;
    VectorXd step = newton_step(problem, at, slope, inner_accuracy, iterate, workspace, report);
    step *= std::min(max_step_fraction(*problem.model, step), felt_share(problem, iterate, step));

    if (!descend(problem, step, slope.dot(step), lagrangian(problem, iterate, at), iterate))
      return {true, i + 1};  // as low as rounding lets it
    add_contacts(problem.contact, iterate.apart, iterate.positions, problem.joining_share, iterate.contacts);
  }
  return {false, std::max(most, 0)};
}

void update_multipliers(const StepProblem& problem, Iterate& iterate) {
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l)
    if (problem.model->limits[l].kind == LimitKind::hard)
      iterate.multipliers[l] = std::max(0.0, iterate.multipliers[l] + relative_penalty * (iterate.evaluation.energy[l] -
                                                                                          problem.materials.limits[l]));
  for (Contact& contact : iterate.contacts) {
    const double penalty = contact_penalty(problem, contact);
    const Vector3d n = contact.normal;
    const Vector3d pushed = contact.force - penalty * relative_motion(problem, iterate.positions, contact);
    const double normal = std::max(0.0, n.dot(contact.force) - penalty * contact.gap);
    const Vector3d tangential = project_to_disc(pushed - n.dot(pushed) * n, contact.friction * normal);
    contact.force = normal * n + tangential;
  }
}

// how long the violation has not fallen
struct Stall {
  double least_violation = std::numeric_limits<double>::infinity();
  int updates = 0;
};

// `settled`: the multipliers so far are held in balance
bool is_stalled(const Quality& quality, bool settled, Stall& stall) {
  const double violation = std::max(quality.max_ratio - 1, 0.0) + 1e-3 * quality.depth;
  if (violation < falling * stall.least_violation || !settled) stall.updates = 0;
  stall.least_violation = std::min(stall.least_violation, violation);
  return violation > clear_violation && ++stall.updates > stalled_updates;
}

void begin(const StepProblem& problem, Iterate& iterate) {
  evaluate(problem, iterate.positions, iterate.evaluation);
  add_contacts(problem.contact, iterate.apart, iterate.positions, problem.joining_share, iterate.contacts);
}

// multipliers, contacts and what is left, after a minimisation
struct Update {
  int added = 0;  // contacts
  Quality quality;
};
Update update(const StepProblem& problem, Iterate& iterate, const StepReport& report) {
  update_multipliers(problem, iterate);
  Update update{.added = find_contacts(problem, false, iterate), .quality = assess(problem, iterate)};
  report_iteration(problem, report.sqp_iterations, update.quality, iterate);
  iterate.residuals.push_back(update.quality.kkt);
  return update;
}

// updates and minimisations in turns, after the first minimisation
Search alternate(const StepProblem& problem, Workspace::Data& workspace, bool settled, int left, Iterate& iterate,
                 StepReport& report) {
  Stall stall;
  while (true) {
    const auto [added, quality] = update(problem, iterate, report);
    if (added == 0 && is_solution(problem, quality, iterate)) return Search::solved;
    if (is_stalled(quality, settled && added == 0, stall)) return Search::infeasible;
    if (left <= 0) return Search::unfinished;
    const Minimisation next = minimise(problem, workspace, left, iterate, report);
    settled = next.settled;
    left -= next.iterations;
  }
}

}  // namespace

Search augmented_lagrangian(const StepProblem& problem, Workspace::Data& workspace, Iterate& iterate,
                            StepReport& report) {
  const int budget = problem.options->solver.max_augmented_iterations;
  begin(problem, iterate);
  const auto [settled, iterations] = minimise(problem, workspace, budget, iterate, report);
  return alternate(problem, workspace, settled, budget - iterations, iterate, report);
}

Search search_torn(const StepProblem& problem, Workspace::Data& workspace, Iterate& iterate, StepReport& report) {
  iterate.multipliers.setZero();
  begin(problem, iterate);
  int left = std::min(max_torn_iterations, problem.options->solver.max_augmented_iterations);
  Minimisation first;
  do {
    first = minimise(problem, workspace, left, iterate, report);
    left -= first.iterations;
  } while (!first.settled && left > 0);
  Iterate minimum = iterate;
  const double ratio = update(problem, minimum, report).quality.max_ratio;
  if (ratio <= 1 + torn && left > 0 &&
      alternate(problem, workspace, first.settled, left, iterate, report) == Search::solved)
    return Search::solved;
  iterate = std::move(minimum);
  return Search::infeasible;
}

}  // namespace umax
