#include "core/step/multigrid_subproblem.h"

#include <algorithm>
#include <cmath>

#include "core/step/bpx_contact_compliance.h"
#include "core/step/held_contacts.h"

namespace umax {
namespace {

constexpr double clear_share = 0.6;  // [-] of the depth that a solution may have
// [-] Of the iterate's deepest contact, how deep one may be after a step that is not the last: where thousands are a
// little too deep, corrections that bring all of them up at once are no response of single contacts.
constexpr double left_share = 0.5;
constexpr double moved_share = 0.05;  // [-] nor need it be less deep than this share of how far contacts move
constexpr int max_corrections = 12;
constexpr int max_clearings = 3;       // of these, where forces have settled and only depths are left to bring down
constexpr double telling_fall = 0.35;  // [-] of the error, from which a solve shows a response to what was changed
// [-] Fall of the error in a solve that corrections of contacts follow, and in these: what the first one leaves over
// spoils what is learnt of the response to forces, and what corrections leave over the next ones make good.
constexpr double first_fall = 0.05, correction_fall = 0.15;
constexpr int max_contact_rounds = 6;  // detections per linearisation
constexpr int max_sweeps = 200;
constexpr double sweep_share = 0.01;         // of what is bearable
constexpr double restoring_accuracy = 0.02;  // [-] of linear systems that restore constraints
// Contacts are no longer held where their forces are not balanced and the correction before has changed them by so many times
// more or otherwise than foretold.
constexpr double most_missed = 2;

// How a subproblem is solved, and how exactly.
struct Accuracy {
  double linear = 0;       // [-] of the linear system
  double settled = 0;      // [-] change of the forces at which contacts are solved
  bool final = false;      // contacts must be as shallow as the solution's
  bool restoring = false;  // forces are in balance: only constraints are restored
};

// The linear system is solved no more exactly than the last iteration has shown to be of use (Eisenstat and Walker
// 1996, their second choice): what turning hexes do is not in it. Contacts are, and the more exactly the nearer the
// iterate is to the step's solution.
Accuracy accuracy_after(const std::vector<double>& residuals, double tolerance) {
  const double kkt_residual = residuals.back();
  const double kkt_fall = residuals.size() > 1 ? kkt_residual / residuals[residuals.size() - 2] : 1;
  const bool restoring = is_balanced(kkt_residual, tolerance);
  const double foretold = std::clamp(0.9 * kkt_fall * kkt_fall, std::min(5 * tolerance, 0.05), 0.05);
  return {.linear = restoring ? restoring_accuracy : foretold,
          .settled = std::clamp(0.3 * kkt_residual, std::min(tolerance, 0.1), 0.1),
          .final = kkt_residual <= near_solution * tolerance,
          .restoring = restoring};
}

// The contacts of a linear system on its way.
struct ContactSolution {
  HeldContacts held;
  VectorXd pushed;   // [N] 3 per contact, by the right-hand side; springs of held contacts push, too
  VectorXd forces;   // [N] that they bear
  double error = 0;  // [-] that is left in the linear system
};

VectorXd push_of(const Model& model, const std::vector<Contact>& contacts, const VectorXd& forces) {
  VectorXd push = VectorXd::Zero(3 * model.num_nodes());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    spread(model, contacts[i], forces.segment<3>(3 * Eigen::Index(i)), push);
  clear_fixed(model, push);
  return push;
}

VectorXd known_forces(const std::vector<Contact>& contacts) {
  VectorXd forces(3 * Eigen::Index(contacts.size()));
  for (std::size_t i = 0; i < contacts.size(); ++i) forces.segment<3>(3 * Eigen::Index(i)) = contacts[i].force;
  return forces;
}

// is no contact deeper after the step than what is allowed [m], or a small share of what is bearable?
bool is_clear(const StepProblem& problem, const Iterate& iterate, const std::vector<ContactRow>& rows,
              const VectorXd& w, double allowed) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double gap = rows[i].bias + rows[i].normal.dot(w.segment<3>(3 * Eigen::Index(i)));
    const double bearable = problem.joining_share * tolerance_depth(*problem.model, iterate.contacts[i]);
    if (gap < -std::max(allowed, clear_share * bearable)) return false;
  }
  return true;
}

SaddlePointReport improve(const SaddlePointOptions& options, MultigridSystem& system, StepReport& report) {
  const SaddlePointReport linear = improve(options, system);
  report.linear_iterations += linear.iterations;
  return linear;
}

// Begins to solve the linear system with these contacts held. known: [N] forces at the iterate, 3 per contact that it had.
ContactSolution begin_linear(const StepProblem& problem, const Linearisation& at, const VectorXd& slope,
                             const Accuracy& accuracy, const VectorXd& known, HeldContacts held, const Iterate& iterate,
                             Workspace::Data& workspace, StepReport& report) {
  const Model& model = *problem.model;
  const std::vector<Contact>& contacts = iterate.contacts;
  set_up_multigrid(problem, at, iterate, spring_terms(contacts, held), workspace);
  ++report.factorisations;
  MultigridSystem& system = *workspace.multigrid;
  ContactSolution solution{.held = std::move(held), .pushed = {}, .forces = known};
  solution.forces.conservativeResizeLike(VectorXd::Zero(3 * Eigen::Index(contacts.size())));
  const VectorXd stretched = spring_forces(solution.held, target_motions(solution.held, contacts.size()));
  solution.pushed = solution.forces - stretched;
  VectorXd missing;
  if (accuracy.restoring)
    missing = push_of(model, contacts, -stretched);
  else
    missing = push_of(model, contacts, solution.pushed) - (slope - system.offset_force);
  begin(model, missing, system);
  const double fall = contacts.empty() || !solution.held.empty() ? 0 : first_fall;
  solution.error = improve({.tolerance = accuracy.linear, .reduction = fall}, system, report).error;
  return solution;
}

// False: held contacts are in the way.
bool solve_contacts(const StepProblem& problem, Iterate& iterate, const Accuracy& accuracy, MultigridSystem& system,
                    StepReport& report, ContactSolution& solution) {
  const Model& model = *problem.model;
  const HeldContacts& held = solution.held;
  BpxContactCompliance compliance = make_bpx_contact_compliance(model, system, iterate.contacts);
  const auto [rows, before] = contact_rows(problem, iterate.positions, iterate.contacts);
  VectorXd motions = contact_motions(model, iterate.contacts, system);
  const double allowed = accuracy.final ? 0
                                        : std::max(left_share * deepest(iterate.contacts),
                                                   moved_share * motions.lpNorm<Eigen::Infinity>());
  bool solved = solution.error <= accuracy.linear;  // or as far as the linear solver gets
  int num_clearings = 0;
  double missed = 0;  // [-] of the change of forces that was last asked for
  for (int i = 0; i < max_corrections; ++i) {
    const VectorXd w = before + motions, borne = solution.pushed + spring_forces(held, motions);
    solution.forces = borne;
    solve_contacts(compliance, rows, w - apply(compliance, borne),
                   {.max_sweeps = max_sweeps, .tolerance = sweep_share * accuracy.settled}, solution.forces);
    const VectorXd change = solution.forces - borne;
    ForceChanges changes(model.bodies.size());
    for (int c = 0; c < int(iterate.contacts.size()); ++c)
      add_changes(compliance, c, change.segment<3>(3 * c), solution.forces.segment<3>(3 * c), changes);
    const bool balanced = changes.are_within(accuracy.settled),
               settled = balanced && is_clear(problem, iterate, rows, w, allowed);
    if (settled && solved) return true;
    if (!held.empty() && !balanced && missed > most_missed) return false;
    if (!settled) {
      const VectorXd push = change - spring_forces(held, apply(compliance, change));
      solution.pushed += push;
      add_contact_forces(model, iterate.contacts, push, system);
    }
    const SaddlePointReport linear =
        improve({.tolerance = accuracy.linear, .reduction = settled ? 0 : correction_fall}, system, report);
    solution.error = linear.error;
    solved = settled || solution.error <= accuracy.linear;
    if (settled && !accuracy.final) return true;  // what that has moved is for the next linearisation
    if (balanced && ++num_clearings == max_clearings && solved) return true;
    const VectorXd moved = contact_motions(model, iterate.contacts, system),
                   changed = solution.pushed + spring_forces(held, moved) - borne;
    missed = settled ? 0 : (changed - change).norm() / change.norm();
    if (!settled && linear.error <= telling_fall * linear.started) learn(changed, moved - motions, compliance);
    motions = moved;
  }
  if (!solved) solution.error = improve({.tolerance = accuracy.linear}, system, report).error;
  solution.forces = solution.pushed + spring_forces(held, contact_motions(model, iterate.contacts, system));
  return true;
}

}  // namespace

void prepare_multigrid(const StepProblem& problem, const Iterate&, Workspace::Data& workspace) {
  multigrid_system(*problem.model, workspace);
}

NewtonStep minimise_multigrid(const StepProblem& problem, const Linearisation& at, const VectorXd& slope,
                              Iterate& iterate, Workspace::Data& workspace, StepReport& report) {
  const Model& model = *problem.model;
  const Accuracy accuracy = accuracy_after(iterate.residuals, problem.options->solver.tolerance);
  const VectorXd known = known_forces(iterate.contacts);
  const auto begin_with = [&](HeldContacts held) {
    return begin_linear(problem, at, slope, accuracy, known, std::move(held), iterate, workspace, report);
  };
  ContactSolution solution = begin_with(hold_contacts(problem, at, iterate));
  MultigridSystem& system = *workspace.multigrid;
  NewtonStep newton;
  for (int round = 0; round < max_contact_rounds; ++round) {
    while (!iterate.contacts.empty() && !solve_contacts(problem, iterate, accuracy, system, report, solution))
      solution = begin_with({});
    for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
      iterate.contacts[i].force = solution.forces.segment<3>(3 * Eigen::Index(i));
    newton = multigrid_step(model, at, system);
    if (add_linearised_contacts(problem, newton.step, true, iterate) == 0) break;
    solution.pushed.conservativeResizeLike(VectorXd::Zero(3 * Eigen::Index(iterate.contacts.size())));
  }
  return newton;
}

}  // namespace umax
