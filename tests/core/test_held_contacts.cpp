// Contacts that springs in the matrix hold to obstacles.
#include "core/step/held_contacts.h"

#include <algorithm>
#include <vector>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/linearised_step.h"

using namespace umax;

namespace {

constexpr double cell = 0.05;  // [m]

Model limited_block() {
  Body block = test::make_block({8, 4, 8}, {0, 0, 0}, cell);
  test::limit_energy(block, 0.02);
  return make_model({block}, {test::make_ground(0.5)});
}

State fallen(const Model& model, int steps) {
  StepOptions options{.time_step = 0.01};
  options.solver.linear = LinearSolver::direct;
  State state = rest_state(model);
  state.velocities.col(1).setConstant(-1);
  test::simulate(model, options, steps, state, [](const StepReport&, const State&) {});
  return state;
}

// One linearisation of a step of the block that presses itself onto the ground.
struct Landing : test::LinearisedStep {
  explicit Landing(const Model& block) : LinearisedStep(block, fallen(block, 3)) {
    update_contacts(problem.contact, iterate.apart, iterate.positions, iterate.contacts);
    iterate.residuals = {1e-2};
  }
  NewtonStep minimise() {
    report = {};
    return LinearisedStep::minimise();
  }
  // holds nothing: only contacts that push are held
  NewtonStep minimise_unheld() {
    for (Contact& contact : iterate.contacts) contact.force.setZero();
    return minimise();
  }
  Vector3d force() const {
    Vector3d sum = Vector3d::Zero();
    for (const Contact& contact : iterate.contacts) sum += contact.force;
    return sum;
  }
};

}  // namespace

TEST_CASE("contacts that push are held along their normals, and where they stick along tangents, too") {
  Landing landing(limited_block());
  std::vector<Contact>& contacts = landing.iterate.contacts;
  REQUIRE(contacts.size() > 20);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double friction = i % 3 == 0 ? 0.2 : 0.5;  // of the normal force: it sticks, it slides
    contacts[i].force = i % 2 == 0 ? Vector3d(friction, 1, 0) : Vector3d(0, 0, 0);
  }
  const HeldContacts held = hold_contacts(landing.problem, landing.at, landing.iterate);
  const auto [rows, before] = contact_rows(landing.problem, landing.iterate.positions, contacts);
  const VectorXd targets = target_motions(held, contacts.size());
  for (int i = 0; i < int(contacts.size()); ++i) {
    const auto count =
        std::count_if(held.begin(), held.end(), [i](const HeldDirection& one) { return one.contact == i; });
    CHECK(count == (i % 2 == 1 ? 0 : i % 3 == 0 ? 3 : 1));
    if (count == 0) continue;
    const Vector3d w = before.segment<3>(3 * i) + targets.segment<3>(3 * i);
    CHECK(std::abs(rows[std::size_t(i)].bias + rows[std::size_t(i)].normal.dot(w)) < 1e-15);
    if (count == 3) CHECK((w - rows[std::size_t(i)].normal.dot(w) * rows[std::size_t(i)].normal).norm() < 1e-15);
  }
}

TEST_CASE(
    "contacts that have slid too far to stick are held along their normals alone, and such as stand off not at all") {
  Landing landing(limited_block());
  std::vector<Contact>& contacts = landing.iterate.contacts;
  for (Contact& contact : contacts) contact.force = {0, 1, 0};
  const Points positions = landing.iterate.positions;
  const auto directions_after = [&](const Vector3d& move) {
    landing.iterate.positions = positions.rowwise() + move.transpose();
    return hold_contacts(landing.problem, landing.at, landing.iterate).size();
  };
  REQUIRE(directions_after({0, 0, 0}) == 3 * contacts.size());
  CHECK(directions_after({1e-9 * cell, 0, 0}) == 3 * contacts.size());
  CHECK(directions_after({0.1 * cell, 0, 0}) == contacts.size());
  CHECK(directions_after({0, 0, -0.1 * cell}) == contacts.size());
  for (Contact& contact : contacts) contact.gap = 0.1 * cell;
  CHECK(directions_after({0, 0, 0}) == 0);
}

TEST_CASE("springs push contacts as their terms push nodes") {
  Landing landing(limited_block());
  const Model& model = landing.model;
  const std::vector<Contact>& contacts = landing.iterate.contacts;
  landing.minimise_unheld();  // finds forces
  const HeldContacts held = hold_contacts(landing.problem, landing.at, landing.iterate);
  REQUIRE(held.size() > contacts.size() / 2);
  test::Random random(5);
  VectorXd x(3 * model.num_nodes()), motions(3 * Eigen::Index(contacts.size()));
  for (double& value : x) value = random.uniform(-1, 1);
  for (std::size_t i = 0; i < contacts.size(); ++i)
    motions.segment<3>(3 * Eigen::Index(i)) = contact_motion(model, contacts[i], x);
  const VectorXd forces = spring_forces(held, motions);
  VectorXd push = VectorXd::Zero(x.size());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    spread(model, contacts[i], forces.segment<3>(3 * Eigen::Index(i)), push);
  const double size = push.norm();
  for (const RankOneTerm& term : spring_terms(contacts, held)) {
    double product = 0;
    for (int n = 0; n < 8; ++n)
      product += term.vector.segment<3>(3 * n).dot(x.segment<3>(3 * model.hexes(term.hex, n)));
    for (int n = 0; n < 8; ++n)
      push.segment<3>(3 * model.hexes(term.hex, n)) += product * term.vector.segment<3>(3 * n);
  }
  CHECK(push.norm() < 1e-12 * size);
}

TEST_CASE("a linearised step is the same with contacts held and without, and found in fewer iterations") {
  Landing held(limited_block()), free(limited_block());
  for (Landing* landing : {&held, &free}) landing->minimise_unheld();
  const NewtonStep with = held.minimise(), without = free.minimise_unheld();
  CAPTURE(held.report.linear_iterations, free.report.linear_iterations);
  CHECK(held.report.factorisations == 1);  // the springs were not in the way
  CHECK((with.step - without.step).norm() < 0.05 * without.step.norm());
  CHECK((held.force() - free.force()).norm() < 0.05 * free.force().norm());
  CHECK(held.report.linear_iterations < 0.8 * free.report.linear_iterations);
}

TEST_CASE("springs that are in the way of contacts that open and slide are given up") {
  Landing held(limited_block()), free(limited_block());
  for (Landing* landing : {&held, &free}) {
    landing->minimise_unheld();
    test::Random random(17);
    // as from an iterate far away: one in three bears everything, which all others will have to
    for (Contact& contact : landing->iterate.contacts) contact.force *= random.uniform(0, 3) < 1 ? 30 : 1e-3;
  }
  const NewtonStep with = held.minimise(), without = free.minimise_unheld();
  CHECK(held.report.factorisations == 2);
  CHECK((with.step - without.step).norm() < 0.1 * without.step.norm());
  CHECK((held.force() - free.force()).norm() < 0.05 * free.force().norm());
  held.minimise();  // from forces that have been found: contacts are held again
  free.minimise_unheld();
  CAPTURE(held.report.linear_iterations, free.report.linear_iterations);
  CHECK(held.report.factorisations == 1);
  CHECK(held.report.linear_iterations < 0.8 * free.report.linear_iterations);
}
