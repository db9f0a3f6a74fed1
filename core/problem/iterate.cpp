#include "core/problem/iterate.h"

#include <algorithm>
#include <cmath>

#include "core/contact/surface_contact.h"
#include "core/element/limit_law.h"
#include "core/element/rotation.h"
#include "core/model/hex_limits.h"
#include "core/problem/body_shares.h"
#include "core/problem/step_length.h"

namespace umax {
namespace {

// A limit that holds to its tolerance may still give or take energy; more than this share of the tolerance of all the
// energy there is would show as energy that rises from nowhere.
constexpr double negligible_work = 1e-4;
constexpr double hidden_work = 0.1;     // share of what the integrator loses in the step anyway
constexpr double far_gap = 50;          // [penetration tolerances]
constexpr double resting_move = 2e-4;   // [cells] in a step
constexpr double exact_guess = 0.01;    // [tolerances] of the residual
constexpr double standing_move = 1e-6;  // [cells] in a step
constexpr double settled_move = 0.05;   // [cells] a larger last move means that the iteration is still on its way
// [cells] What moves less is at rest to the last bits: what forces then miss, at most so many tolerances, is rounding, as where
// stiff springs of pins and a body that they tear pull against each other.
constexpr double rounding_move = 1e-12;
constexpr double rounding_residual = 100;  // [tolerances]

// the body's rest shape, moved and turned to where its nodes are
void place_undeformed(const Model& model, const Model::BodyRange& body, Points& positions) {
  const auto mass = model.node_mass.segment(body.first_node, body.num_nodes);
  const auto rest = model.rest_positions.middleRows(body.first_node, body.num_nodes);
  auto placed = positions.middleRows(body.first_node, body.num_nodes);
  const Eigen::RowVector3d rest_centre = mass.transpose() * rest / mass.sum();
  const Eigen::RowVector3d centre = mass.transpose() * placed / mass.sum();
  const Points arms = rest.rowwise() - rest_centre;
  const Matrix3d rotation = polar_rotation((placed.rowwise() - centre).transpose() * mass.asDiagonal() * arms);
  placed = (arms * rotation.transpose()).rowwise() + centre;
}

// kinetic energy, elastic energy and the weight times the bodies' heights [J]
double energy_scale(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  double sum = iterate.evaluation.elastic_energy.sum();
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    sum += 0.5 * model.node_mass[node] * problem.velocities_t0.row(node).squaredNorm();
  for (const Model::BodyRange& body : model.bodies) {
    const auto rest = model.rest_positions.middleRows(body.first_node, body.num_nodes);
    const double diagonal = (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm();
    sum += model.node_mass.segment(body.first_node, body.num_nodes).sum() * problem.options->gravity.norm() * diagonal;
  }
  return sum;
}

// what implicit Euler loses in the step [J]: 1/2 |v1 - v0|^2 by mass
double integrator_loss(const StepProblem& problem, const Points& positions) {
  const Model& model = *problem.model;
  double sum = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    const Eigen::RowVector3d velocity = (positions.row(node) - problem.positions_t0.row(node)) / problem.h;
    sum += 0.5 * model.node_mass[node] * (velocity - problem.velocities_t0.row(node)).squaredNorm();
  }
  return sum;
}

// work of limits [J] that cannot show
double bearable_work(const StepProblem& problem, const Iterate& iterate) {
  return negligible_work * problem.options->solver.tolerance * energy_scale(problem, iterate) +
         hidden_work * integrator_loss(problem, iterate.positions);
}

// Has a vertex that pushes no more gone far from the body that it touched? One whose normal has turned back may come again:
// forgotten, it would turn to and fro for ever.
bool is_over(const Model& model, const Contact& contact) {
  return contact.between_bodies() && contact.turns_back == 0 && contact.force.isZero(0) &&
         contact.gap > far_gap * tolerance_depth(model, contact);
}

// which bodies nothing holds up: no clamp, no obstacle and no other body in the step before
std::vector<char> falling_bodies(const Model& model, const State& state) {
  std::vector<char> falls(model.bodies.size(), 1);
  for (std::size_t b = 0; b < falls.size(); ++b) {
    const auto first = model.node_fixed.begin() + model.bodies[b].first_node;
    if (std::find(first, first + model.bodies[b].num_nodes, 1) != first + model.bodies[b].num_nodes) falls[b] = 0;
  }
  for (const State::ContactImpulse& contact : state.contacts)
    if (contact.other_hex < 0 || model.hex_body[contact.hex] != model.hex_body[contact.other_hex])
      for (const int hex : {contact.hex, contact.other_hex})
        if (hex >= 0) falls[std::size_t(model.hex_body[hex])] = 0;
  return falls;
}

// Which bodies touch others and hardly move: their steps start from where they are. Else a pile would creep on for ever, by
// less than what a step's tolerance can tell.
std::vector<char> resting_bodies(const StepProblem& problem, const State& state) {
  const Model& model = *problem.model;
  std::vector<char> rests(model.bodies.size(), 0);
  for (const State::ContactImpulse& contact : state.contacts)
    if (contact.other_hex >= 0 && model.hex_body[contact.hex] != model.hex_body[contact.other_hex])
      for (const int hex : {contact.hex, contact.other_hex}) rests[std::size_t(model.hex_body[hex])] = 1;
  for (std::size_t b = 0; b < rests.size(); ++b) {
    const auto velocities = problem.velocities_t0.middleRows(model.bodies[b].first_node, model.bodies[b].num_nodes);
    const double farthest = problem.h * velocities.rowwise().norm().maxCoeff();  // [m]
    if (farthest > resting_move * model.bodies[b].cell_size) rests[b] = 0;
  }
  return rests;
}

// Bodies that something holds go along their ways only as far as a step of the iteration would. A guess in which a clamp tears
// a flying body's side by cells would have to be mended a fifth of a cell at a time.
void shorten_ways(const StepProblem& problem, const std::vector<char>& falls, Points& positions) {
  VectorXd way = flatten(positions - problem.positions_t0);
  VectorXd shares = step_fractions(*problem.model, way);
  for (std::size_t b = 0; b < falls.size(); ++b)
    if (falls[b]) shares[Eigen::Index(b)] = 1;
  if ((shares.array() == 1).all()) return;
  scale_bodies(*problem.model, shares, way);
  positions = problem.positions_t0 + unflatten(way);
}

}  // namespace

Iterate predict(const StepProblem& problem, const State& state) {
  const Model& model = *problem.model;
  const double h = problem.h;
  const Points& forces = problem.options->forces;
  const std::vector<char> falls = falling_bodies(model, state), rests = resting_bodies(problem, state);
  Iterate iterate;
  iterate.positions = problem.positions_t0;
  iterate.apart = LastApart(iterate.positions);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    for (int i = 0; i < model.bodies[b].num_nodes && !rests[b]; ++i) {
      const int node = model.bodies[b].first_node + i;
      if (model.node_fixed[node]) continue;
      const Eigen::RowVector3d velocity = problem.velocities_t0.row(node);
      Eigen::RowVector3d gained = h * problem.options->gravity.transpose();  // speed, where nothing holds a body up
      if (forces.rows() > 0) gained += h / model.node_mass[node] * forces.row(node);
      iterate.positions.row(node) +=
          h * (falls[b] ? Eigen::RowVector3d((velocity + gained) / (1 + h * problem.damping_mass[node])) : velocity);
    }
  shorten_ways(problem, falls, iterate.positions);
  place_driven(problem.pins, iterate.positions);
  iterate.multipliers = state.limit_multipliers;
  iterate.released.assign(model.limits.size(), 0);
  iterate.contacts = recall_contacts(problem, state, iterate.positions);
  return iterate;
}

Iterate predict_undeformed(const StepProblem& problem, const State& state) {
  const Model& model = *problem.model;
  Iterate iterate = predict(problem, state);
  for (const Model::BodyRange& body : model.bodies) place_undeformed(model, body, iterate.positions);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (model.node_fixed[node]) iterate.positions.row(node) = problem.positions_t0.row(node);
  place_driven(problem.pins, iterate.positions);
  iterate.multipliers.setZero();
  for (Contact& contact : iterate.contacts) contact.force.setZero();
  update_contacts(problem.contact, iterate.apart, iterate.positions, iterate.contacts);
  return iterate;
}

int find_contacts(const StepProblem& problem, bool keeps_normals, Iterate& iterate) {
  std::erase_if(iterate.contacts, [&](const Contact& contact) { return is_over(*problem.model, contact); });
  if (keeps_normals) {
    for (Contact& contact : iterate.contacts)
      if (!contact.between_bodies()) follow(*problem.model, iterate.positions, contact);
    place_surface_contacts(problem.contact, iterate.apart, iterate.positions, iterate.contacts);
  } else {
    update_contacts(problem.contact, iterate.apart, iterate.positions, iterate.contacts);
  }
  make_room_for_planes(*problem.model, iterate.contacts);
  const int added =
      add_contacts(problem.contact, iterate.apart, iterate.positions, problem.joining_share, iterate.contacts);
  if (problem.contact.geometry->touchable.any())
    remember_apart(*problem.model, iterate.contacts, iterate.positions, iterate.apart);
  return added;
}

int add_linearised_contacts(const StepProblem& problem, const VectorXd& step, bool with_bodies, Iterate& iterate) {
  const auto before = std::ptrdiff_t(iterate.contacts.size());
  int count = add_obstacle_contacts(problem.contact, iterate.positions + unflatten(step), problem.joining_share,
                                    iterate.contacts);
  if (with_bodies && problem.contact.geometry->touchable.any()) {
    VectorXd taken = step;
    scale_bodies(*problem.model, body_shares(problem, iterate, step), taken);
    count += add_surface_contacts(problem.contact, iterate.apart, iterate.positions + unflatten(taken),
                                  problem.joining_share, iterate.contacts);
  }
  std::vector<Contact> added(iterate.contacts.begin() + before, iterate.contacts.end());
  update_contacts(problem.contact, iterate.apart, iterate.positions, added);
  std::copy(added.begin(), added.end(), iterate.contacts.begin() + before);
  return count;
}

VectorXd limit_factors(const StepProblem& problem, const Iterate& iterate) {
  VectorXd factors(problem.materials.limits.size());
  for (Eigen::Index l = 0; l < factors.size(); ++l)
    factors[l] = problem.model->limits[l].kind == LimitKind::hard
                     ? iterate.multipliers[l] / problem.materials.limits[l]
                     : soft_limit_terms(iterate.evaluation.energy[l], problem.materials.limits[l], {}).force;
  return factors;
}

Quality assess(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  Quality quality;
  // a hex beyond its limit that is not pushed yet may be pushed as hard as the hardest pushed one is
  const double largest = iterate.multipliers.size() ? iterate.multipliers.maxCoeff() : 0;
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l) {
    if (model.limits[l].kind != LimitKind::hard) continue;
    const double ratio = iterate.evaluation.energy[l] / problem.materials.limits[l];
    quality.max_ratio = std::max(quality.max_ratio, ratio);
    if (iterate.multipliers[l] > problem.options->solver.tolerance * problem.materials.limits[l])
      quality.complementarity = std::max(quality.complementarity, std::abs(1 - ratio));
    const double multiplier = iterate.multipliers[l];
    if (multiplier > 0 || ratio > 1)
      quality.limit_work += (multiplier > 0 ? multiplier : largest) * std::abs(1 - ratio);
  }
  for (const Contact& contact : iterate.contacts)
    quality.depth = std::max(quality.depth, -contact.gap / tolerance_depth(model, contact));
  quality.kkt =
      kkt_residual(problem, iterate.evaluation, iterate.positions, limit_factors(problem, iterate), iterate.contacts);
  return quality;
}

bool is_solution(const StepProblem& problem, const Quality& quality, const Iterate& iterate) {
  const double tolerance = problem.options->solver.tolerance;
  const bool is_rounded = !problem.pins.springs.empty() && iterate.residuals.size() > 1 &&
                          iterate.last_move <= rounding_move && is_balanced(quality.kkt, rounding_residual * tolerance);
  return (is_rounded || is_balanced(quality.kkt, tolerance)) && quality.max_ratio <= 1 + tolerance &&
         quality.complementarity <= tolerance && quality.limit_work <= bearable_work(problem, iterate) &&
         quality.depth <= problem.joining_share && iterate.last_move <= settled_move;
}

bool is_exact_guess(const StepProblem& problem, const Quality& quality, const Iterate& iterate) {
  if (is_balanced(quality.kkt, exact_guess * problem.options->solver.tolerance)) return true;
  const Model& model = *problem.model;
  const VectorXd moved = (iterate.positions - problem.positions_t0).rowwise().norm();
  return std::all_of(model.bodies.begin(), model.bodies.end(), [&](const Model::BodyRange& body) {
    return moved.segment(body.first_node, body.num_nodes).maxCoeff() <= standing_move * body.cell_size;
  });
}

void report_iteration(const StepProblem& problem, int iteration, const Quality& quality, const Iterate& iterate) {
  if (!problem.options->on_iteration) return;
  problem.options->on_iteration({.iteration = iteration,
                                 .max_energy_ratio = quality.max_ratio,
                                 .max_penetration = deepest(iterate.contacts),
                                 .largest_move = iterate.last_move,
                                 .kkt_residual = quality.kkt,
                                 .limits_active = count_hexes(*problem.model, limit_factors(problem, iterate)),
                                 .contacts = int(iterate.contacts.size())});
}

}  // namespace umax
