#include "core/step/contact_forces.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "core/step/contact_newton.h"
#include "core/step/contact_part.h"

namespace umax {
namespace {

constexpr std::size_t mixed_sweeps = 8;  // of which the mean is taken
constexpr int sweeps_between_means = 3;  // else sets of contacts that push and slide have no time to settle
constexpr double spoiling_growth = 2;    // of what a sweep changes: from there on earlier sweeps tell nothing
constexpr int sweeps_between = 20;       // tries of Newton's method; after one that failed, twice as many
constexpr double kept_product = 1e-12, most_weight = 1e4;  // [-] of means of sweeps that are nearly alike
constexpr double near = 1e-4;  // [-] what is left where sets may be right: Newton's method needs them
constexpr int few = 50;        // contacts: of so few a try costs nothing, and all are swept over
constexpr int sweeps_over_all = 10, sweeps_until_look = 20;  // then over those that push; after each look twice as many

// one projected Gauss-Seidel sweep over all contacts
ForceChanges sweep(const ContactProblem& problem, ContactState& state) {
  ForceChanges changes(problem.delassus.bodies.size());
  for (int i = 0; i < problem.count(); ++i) {
    const Vector3d old = state.forces.segment<3>(3 * i);
    const Vector3d change =
        relaxed_force(problem.contacts[i], problem.blocks[i], motion_of(problem, state, i), old) - old;
    if (change.squaredNorm() > 0) {
      state.forces.segment<3>(3 * i) += change;
      for_each_side(problem.delassus, i, [&](const Delassus::Side& side) {
        state.motions[side.body].noalias() +=
            problem.delassus.bodies[side.body].W.middleCols<3>(3 * side.point) * Vector3d(side.sign * change);
      });
    }
    count_change(problem, i, change, state.forces.segment<3>(3 * i), changes);
  }
  return changes;
}

// Has a sweep changed nothing but how contacts share what they bear together? Where there are more contacts than the nodes
// under them can tell apart, forces go from one to another for thousands of sweeps, and neither the nodes' forces nor
// anything that moves changes with them. Changes df that move their body by dw = W df are measured by the energy df . dw,
// which is that of the nodes' forces, beside that of all contact forces on the body.
bool moves_nothing(const ContactProblem& problem, const ContactState& before, const ContactState& now, double share) {
  const std::vector<VectorXd> change = at_points(problem.delassus, now.forces - before.forces),
                              all = at_points(problem.delassus, now.forces);
  for (std::size_t b = 0; b < all.size(); ++b)
    if (change[b].dot(now.motions[b] - before.motions[b]) >
        share * share * all[b].dot(now.motions[b] - problem.free_motions[b]))
      return false;
  return true;
}

// The last sweeps: what they changed of the forces, and what they ended at.
struct Sweeps {
  std::vector<VectorXd> changes;
  std::vector<ContactState> ends;
  int since_mean = 0;
};

void add(const VectorXd& before, const ContactState& end, Sweeps& sweeps) {
  VectorXd change = end.forces - before;
  const bool is_spoilt = !sweeps.changes.empty() && change.norm() > spoiling_growth * sweeps.changes.back().norm();
  if (is_spoilt) sweeps = {};
  if (sweeps.changes.size() == mixed_sweeps) {
    sweeps.changes.erase(sweeps.changes.begin());
    sweeps.ends.erase(sweeps.ends.begin());
  }
  sweeps.changes.push_back(std::move(change));
  sweeps.ends.push_back(end);
}

// Moves the state, which is the end of the last sweep, to the mean of the last ends, weighted so that the same mean of their
// changes is least; weights add up to 1, and may be negative.
void take_mean(Sweeps& sweeps, ContactState& state) {
  const auto earlier = Eigen::Index(sweeps.changes.size()) - 1;
  if (earlier < 1 || ++sweeps.since_mean % sweeps_between_means != 0) return;
  MatrixXd against_last(sweeps.changes.back().size(), earlier);
  for (Eigen::Index i = 0; i < earlier; ++i)
    against_last.col(i) = sweeps.changes[std::size_t(i)] - sweeps.changes.back();
  MatrixXd products = against_last.transpose() * against_last;
  products.diagonal().array() += kept_product * products.trace();
  const VectorXd weights = products.ldlt().solve(-against_last.transpose() * sweeps.changes.back());
  if (!weights.allFinite() || weights.lpNorm<1>() > most_weight) {
    sweeps = {};
    return;
  }
  const ContactState& last = sweeps.ends.back();
  for (Eigen::Index i = 0; i < earlier; ++i) {
    const ContactState& end = sweeps.ends[std::size_t(i)];
    state.forces += weights[i] * (end.forces - last.forces);
    for (std::size_t b = 0; b < state.motions.size(); ++b)
      state.motions[b] += weights[i] * (end.motions[b] - last.motions[b]);
  }
}

// How far the sweeps are.
struct Course {
  int sweeps = 0;
  bool converged = false;
  Sweeps last;
  int between = sweeps_between, next_try = sweeps_between;
};

// Sweeps and what goes with them, until so many are made. The state is then the end of a sweep, or of Newton's method: means may
// be outside of the cones.
void settle(const ContactProblem& problem, const GaussSeidelOptions& options, int end, Course& course,
            ContactState& state) {
  while (!course.converged && course.sweeps < end) {
    ++course.sweeps;
    const ContactState before = state;
    course.converged = sweep(problem, state).are_within(options.tolerance) ||
                       moves_nothing(problem, before, state, 0.1 * options.tolerance);
    if (course.converged || course.sweeps == end) return;
    add(before.forces, state, course.last);
    take_mean(course.last, state);
    if (course.sweeps < course.next_try) continue;
    const bool tries = problem.count() <= few || (!options.is_rough && what_is_left(problem, state) <= near);
    if (tries && !try_newton(problem, options.tolerance, state)) course.between *= 2;
    if (tries) course.last = {};
    course.next_try = course.sweeps + (tries ? course.between : sweeps_between);
  }
}

// Marks contacts that push, or have to at the motions; are any new?
bool let_join(const ContactProblem& problem, const ContactState& state, std::vector<char>& joined) {
  bool is_any_new = false;
  for (int i = 0; i < problem.count(); ++i) {
    if (joined[std::size_t(i)]) continue;
    const ContactRow& contact = problem.contacts[std::size_t(i)];
    const double gap = contact.normal.dot(motion_of(problem, state, i)) + contact.bias;
    joined[std::size_t(i)] = gap < 0 || !state.forces.segment<3>(3 * i).isZero(0);
    is_any_new = is_any_new || joined[std::size_t(i)];
  }
  return is_any_new;
}

std::vector<int> numbers_of(const std::vector<char>& marked) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < marked.size(); ++i)
    if (marked[i]) numbers.push_back(int(i));
  return numbers;
}

// The same for many contacts: first over all, then over those that push or have to.
void settle_in_part(const ContactProblem& problem, const GaussSeidelOptions& options, Course& course,
                    ContactState& state) {
  settle(problem, options, std::min(sweeps_over_all, options.max_sweeps), course, state);
  std::vector<char> joined(std::size_t(problem.count()), 0);
  let_join(problem, state, joined);
  bool is_any_new = false;
  while (!course.converged && course.sweeps < options.max_sweeps) {
    const ContactPart part(problem, numbers_of(joined));
    ContactState of_part = part.state_of(state);
    course.last = {};
    is_any_new = false;
    for (int sweeps = sweeps_until_look; !is_any_new && !course.converged && course.sweeps < options.max_sweeps;
         sweeps *= 2) {
      settle(part.problem(), options, std::min(options.max_sweeps, course.sweeps + sweeps), course, of_part);
      state = part.state_of_all(of_part);
      is_any_new = let_join(problem, state, joined);
      course.converged = course.converged && !is_any_new;
    }
  }
  if (is_any_new)  // what joined last has not pushed yet
    for (int i = 0; i < sweeps_over_all; ++i) sweep(problem, state);
}

}  // namespace

GaussSeidelResult solve_contacts(const Delassus& delassus, const std::vector<ContactRow>& contacts, const VectorXd& q,
                                 const GaussSeidelOptions& options, VectorXd& forces) {
  const ContactProblem problem = make_contact_problem(delassus, contacts, q, {forces, options.proximal_weight});
  ContactState state{forces, motions_of(problem, forces)};
  Course course;
  if (problem.count() > few)
    settle_in_part(problem, options, course, state);
  else
    settle(problem, options, options.max_sweeps, course, state);
  forces = state.forces;
  return {course.sweeps, course.converged};
}

}  // namespace umax
