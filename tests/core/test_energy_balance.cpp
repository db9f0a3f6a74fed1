// Backward Euler, limits and contacts only ever take energy: what a run's steps do to the sum, and to the potential
// that each of them minimises.
#include <sstream>

#include "tests/support/armadillo.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/reference_mechanics.h"

using namespace umax;

namespace {

constexpr double negligible_share = 1e-6;  // of kinetic + elastic + m g x body height

struct Balance {
  int steps = 0, rises = 0, halved = 0, not_converged = 0;
  double largest_rise = 0, largest_ratio = 0;  // [-]
  int limits = 0, contacts = 0;                // most active
  std::ostringstream list;                     // of rises
};

double total_energy(const StepReport& report) {
  return report.kinetic_energy + report.elastic_energy + report.potential_energy;
}

double work(const Points& forces, const Points& motion) {
  return forces.cwiseProduct(motion).sum();
}

// what a gain of energy is made of, in shares of `unit`; the parts sum up to it
std::string causes(const Model& model, const StepOptions& options, const State& before, const State& after,
                   const StepReport& last, const StepReport& report, double unit) {
  std::ostringstream text;
  if (report.retries > 0) return " (a halved step)";
  const test::ReferenceStep step = test::make_reference_step(model, options, before);
  const test::ReferenceForces forces = test::reference_forces(step, after);
  const Points motion = after.positions - before.positions;
  const double inertia = report.kinetic_energy - last.kinetic_energy - work(forces.inertia, motion);
  const double elastic = report.elastic_energy - last.elastic_energy - work(forces.elastic, motion);
  text << ": from the integrator " << inertia / unit << ", elastic curvature " << elastic / unit << ", limits "
       << -work(forces.limit, motion) / unit << ", contacts " << -work(forces.contact, motion) / unit << ", damping "
       << -work(forces.damping, motion) / unit << ", what is left of the residual "
       << work(forces.sum(), motion) / unit;
  return text.str();
}

// steps from a feasible state and keeps account
void run(const Model& model, const StepOptions& options, int steps, State& state, Balance& balance) {
  const double height = model.rest_positions.col(1).maxCoeff() - model.rest_positions.col(1).minCoeff();
  const double weight_energy = model.node_mass.sum() * options.gravity.norm() * height;
  StepReport last = measure(model, options, state);
  REQUIRE(last.max_energy_ratio <= 1);
  REQUIRE(last.max_penetration == 0);
  State before = state;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& now) {
    const double unit = last.kinetic_energy + last.elastic_energy + weight_energy;
    const double rise = (total_energy(report) - total_energy(last)) / unit;
    ++balance.steps;
    if (rise > negligible_share) {
      ++balance.rises;
      balance.list << "\n  step " << now.step << " by " << rise << " with " << report.limits_active << " limits, "
                   << report.contacts << " contacts" << causes(model, options, before, now, last, report, unit);
    }
    balance.largest_rise = std::max(balance.largest_rise, rise);
    balance.largest_ratio = std::max(balance.largest_ratio, report.max_energy_ratio);
    balance.halved += report.retries > 0;
    balance.not_converged += report.status != StepStatus::converged;
    balance.limits = std::max(balance.limits, report.limits_active);
    balance.contacts = std::max(balance.contacts, report.contacts);
    last = report;
    before = now;
  });
}

void check_balance(const Balance& balance) {
  if (balance.rises > 0)
    WARN(balance.rises << " of " << balance.steps << " steps gained energy, in shares of it:" << balance.list.str());
  CHECK(1000 * balance.rises <= balance.steps);
  CHECK(balance.not_converged == 0);
}

StepOptions options_with(double tolerance, double time_step = 0.01) {
  StepOptions options{.time_step = time_step};
  options.solver.tolerance = tolerance;
  return options;
}

Balance balance_of(const Body& body, const std::vector<Obstacle>& obstacles, const StepOptions& options, int steps) {
  const Model model = make_model({body}, obstacles);
  State state = rest_state(model);
  Balance balance;
  run(model, options, steps, state, balance);
  check_balance(balance);
  return balance;
}

Body falling_sphere(double limit) {
  Body sphere = test::make_sphere(3, {0, 1.05, 0});
  sphere.velocity = {0, -4.3, 0};  // as from 2 m
  if (limit > 0) test::limit_energy(sphere, limit);
  return sphere;
}

Body sliding_cube() {
  Body cube = test::make_block({3, 3, 3}, {0, 0.02, 0}, 0.1);
  cube.material.young = 5e4;
  cube.velocity = {1.5, -0.5, 0.2};
  cube.friction = 0.4;
  return cube;
}

struct PotentialCheck {
  int judged = 0, above = 0;
  double highest = -1;  // [-] (end - start) / |start|
};

// Phi(end) against Phi(predictor) in steps whose predictor is feasible
PotentialCheck potentials(const Body& body, const std::vector<Obstacle>& obstacles, State state,
                          const StepOptions& options, int steps) {
  const Model model = make_model({body}, obstacles);
  PotentialCheck result;
  State before = state;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& after) {
    REQUIRE(report.status == StepStatus::converged);
    const test::ReferenceStep step = test::make_reference_step(model, options, before);
    const Points x = test::predictor(step);
    bool feasible = report.retries == 0;
    for (Eigen::Index l = 0; l < step.limits.size(); ++l)
      feasible = feasible && test::reference_energy(step.limited[l], test::nodes_at(step, x, model.limits[l].hex)) <=
                                 step.limits[l];
    for (Eigen::Index p = 0; p < (obstacles.empty() ? 0 : model.num_points()); ++p)
      feasible = feasible && test::ground_gap(step, x, p) >= 0;
    before = after;
    if (!feasible) return;
    const double start = test::incremental_potential(step, x), end = test::incremental_potential(step, after.positions);
    ++result.judged;
    result.above += end > start + 1e-12 * std::abs(start);
    result.highest = std::max(result.highest, (end - start) / std::abs(start));
  });
  return result;
}

}  // namespace

TEST_CASE("the limited beam never gains energy") {
  const double tolerance = GENERATE(1e-3, 1e-6);
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  CHECK(balance_of(beam, {}, options_with(tolerance), 300).limits > 20);
}

TEST_CASE("the beam with a hundredth of a joule a hex never gains energy") {
  const double tolerance = GENERATE(1e-3, 1e-4, 1e-6);
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.01);
  CHECK(balance_of(beam, {}, options_with(tolerance), 300).limits > 40);
}

TEST_CASE("a sphere that falls on the ground never gains energy, with and without limits") {
  const double limit = GENERATE(500.0, 20.0, 0.0), tolerance = GENERATE(1e-3, 1e-6);
  CAPTURE(limit, tolerance);
  const Balance balance = balance_of(falling_sphere(limit), {test::make_ground(0.5)}, options_with(tolerance), 300);
  CHECK(balance.contacts > 2);
  if (limit > 0) CHECK(balance.limits > 10);
}

TEST_CASE("a cube that lands, slides and stops never gains energy") {
  const double limit = GENERATE(0.0, 0.05), tolerance = GENERATE(1e-3, 1e-6);
  CAPTURE(limit, tolerance);
  Body cube = sliding_cube();
  if (limit > 0) test::limit_energy(cube, limit);
  CHECK(balance_of(cube, {test::make_ground()}, options_with(tolerance), 300).contacts > 3);
}

TEST_CASE("the armadillo falls from 2 m within its limits and never gains energy", "[slow][models]") {
  for (const double limit : {100.0, 20.0, 5.0}) {
    CAPTURE(limit);
    Body body = test::make_armadillo(2);
    test::limit_energy(body, limit);
    const Balance balance = balance_of(body, {test::make_ground(0.5)}, options_with(1e-3, 1.0 / 60), 150);
    CHECK(balance.largest_ratio <= 1.001);
    CHECK(balance.limits > 0);
  }
}

TEST_CASE("a step never ends above the potential of its feasible predictor") {
  Body beam = test::make_beam();
  beam.material.damping_mass = 1;
  beam.material.damping_stiffness = 1e-3;
  const double limit = GENERATE(0.0, 0.1);
  CAPTURE(limit);
  if (limit > 0) test::limit_energy(beam, limit);
  const PotentialCheck swing = potentials(beam, {}, rest_state(make_model({beam}, {})), options_with(1e-3), 150);
  CHECK(swing.judged > 10);
  CHECK(swing.above == 0);
}

TEST_CASE("a step in flight never ends above the potential of its feasible predictor") {
  Body block = test::make_block({3, 3, 3}, {0, 5, 0}, 0.1);
  block.material.young = 5e4;
  block.spin = {9, -6, 12};
  test::limit_energy(block, 0.02);
  State state = rest_state(make_model({block}, {}));
  state.velocities.col(0) += 4 * (state.positions.col(0).array() - 0.15).matrix();
  const PotentialCheck flight = potentials(block, {}, state, options_with(1e-3), 150);
  CHECK(flight.judged > 50);
  CHECK(flight.above == 0);
}

TEST_CASE("a frictionless fall never ends a step above the potential of its feasible predictor") {
  const double limit = GENERATE(0.0, 100.0);
  CAPTURE(limit);
  Body sphere = falling_sphere(limit);
  sphere.friction = 0;
  const std::vector<Obstacle> ground{test::make_ground()};
  State state = rest_state(make_model({sphere}, ground));
  state.positions.col(1).array() += 0.5;  // a dozen steps in flight first
  const PotentialCheck fall = potentials(sphere, ground, state, options_with(1e-3), 150);
  CHECK(fall.judged > 10);
  CHECK(fall.above == 0);
}

TEST_CASE("runs from positions that are off by a millionth of a cell keep limits, status and energy", "[slow]") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  for (const bool falls : {false, true}) {
    const Model model = falls ? make_model({falling_sphere(20)}, {test::make_ground(0.5)}) : make_model({beam}, {});
    const double jitter = 1e-6 * model.bodies[0].cell_size;
    Balance balance;
    for (int seed = 0; seed < 10; ++seed) {
      CAPTURE(falls, seed);
      test::Random random(100 + seed);
      State state = rest_state(model);
      for (Eigen::Index i = 0; i < model.num_nodes(); ++i)
        if (!model.node_fixed[i]) state.positions.row(i) += random.vector(jitter).transpose();
      run(model, options_with(1e-3), 150, state, balance);
    }
    check_balance(balance);
    CHECK(balance.largest_ratio <= 1.001);
    CHECK(balance.limits > 10);
  }
}
