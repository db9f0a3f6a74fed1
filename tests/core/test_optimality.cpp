// The end of a step is a solution: stationary, complementary and feasible, recomputed from what the states store.
// A surface point joins the contacts once it is half the contact tolerance deep: the others are only held to that.
#include <algorithm>
#include <cmath>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/reference_mechanics.h"

using namespace umax;
using test::ReferenceStep;

namespace {

// all in shares: of the largest force, of the limit, of the largest force
struct Residuals {
  double stationarity = 0;
  double limit_excess = 0, limit_complementarity = 0;
  double contact = 0;      // Signorini and Coulomb where an impulse acts
  double penetration = 0;  // [cells] of all surface points
  int limits = 0, contacts = 0, sliding = 0, sticking = 0;
};

void keep_larger(Residuals& a, const Residuals& b) {
  a.stationarity = std::max(a.stationarity, b.stationarity);
  a.limit_excess = std::max(a.limit_excess, b.limit_excess);
  a.limit_complementarity = std::max(a.limit_complementarity, b.limit_complementarity);
  a.contact = std::max(a.contact, b.contact);
  a.penetration = std::max(a.penetration, b.penetration);
  a.limits = std::max(a.limits, b.limits);
  a.contacts = std::max(a.contacts, b.contacts);
  a.sliding += b.sliding;
  a.sticking += b.sticking;
}

double largest_free(const Model& model, const Points& forces) {
  double largest = 0;
  for (Eigen::Index i = 0; i < forces.rows(); ++i)
    if (!model.node_fixed[i]) largest = std::max(largest, forces.row(i).cwiseAbs().maxCoeff());
  return largest;
}

// the ground's normal is y: pressure against gap, friction against sliding, both as forces by the point's own mass
double contact_residual(const ReferenceStep& step, const State& after, const State::ContactImpulse& contact,
                        Residuals& count) {
  const Model& model = *step.model;
  double mass = 0;
  Vector3d moved = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) {
    const int node = model.hexes(contact.hex, n);
    mass += surface_weights(model, contact.point.index)[n] * model.node_mass[node];
    moved += surface_weights(model, contact.point.index)[n] *
             (after.positions.row(node) - step.before.positions.row(node)).transpose();
  }
  const double stiffness = mass / (step.h * step.h);
  const double gap = test::ground_gap(step, after.positions, contact.point.index);
  const Vector3d force = contact.impulse / step.h;
  // complementary: whatever is smaller vanishes
  const double normal = std::abs(std::min(force.y(), stiffness * gap));
  // friction is what sticking would need, cut to the cone
  const double friction = std::max(model.bodies[model.hex_body[contact.hex]].friction, model.obstacles[0].friction);
  const Eigen::Vector2d tangential(force.x(), force.z()), sliding(moved.x(), moved.z());
  const Eigen::Vector2d wanted = tangential - stiffness * sliding;
  const double radius = friction * std::max(0.0, force.y());
  const bool slides = wanted.norm() > radius;
  const Eigen::Vector2d allowed = slides ? Eigen::Vector2d(wanted * (radius / wanted.norm())) : wanted;
  count.sliding += slides && friction > 0;
  count.sticking += !slides;
  return std::max(normal, (tangential - allowed).cwiseAbs().maxCoeff());
}

Residuals residuals(const Model& model, const StepOptions& options, const State& before, const State& after) {
  const ReferenceStep step = test::make_reference_step(model, options, before);
  const test::ReferenceForces forces = test::reference_forces(step, after);
  const double scale = std::max({largest_free(model, forces.inertia), largest_free(model, forces.gravity),
                                 largest_free(model, forces.elastic + forces.damping),
                                 largest_free(model, forces.limit), largest_free(model, forces.contact)});
  Residuals result;
  result.stationarity = largest_free(model, forces.sum()) / scale;
  for (Eigen::Index l = 0; l < step.limits.size(); ++l) {
    const double multiplier = after.limit_multipliers[l];
    const test::NodesOf<double> nodes = test::nodes_at(step, after.positions, model.limits[l].hex);
    const double excess = test::reference_energy(step.limited[l], nodes) / step.limits[l] - 1;
    CHECK(multiplier >= 0);
    result.limit_excess = std::max(result.limit_excess, excess);
    result.limit_complementarity =
        std::max(result.limit_complementarity, std::min(multiplier / step.limits[l], std::abs(excess)));
    result.limits += multiplier > 0;
  }
  for (const State::ContactImpulse& contact : after.contacts)
    result.contact = std::max(result.contact, contact_residual(step, after, contact, result) / scale);
  result.contacts = int(after.contacts.size());
  if (!model.obstacles.empty())
    for (Eigen::Index p = 0; p < model.num_points(); ++p)
      result.penetration =
          std::max(result.penetration, -test::ground_gap(step, after.positions, p) / model.bodies[0].cell_size);
  return result;
}

StepOptions tight_options(double tolerance = 1e-6) {
  StepOptions options{.time_step = 0.01};
  options.solver.tolerance = tolerance;
  return options;
}

// the worst of all steps; a step that was halved ends with the velocity of its last part and cannot be judged so
Residuals worst_of_run(const Body& body, const std::vector<Obstacle>& obstacles, int steps, double tolerance = 1e-6) {
  const Model model = make_model({body}, obstacles);
  const StepOptions options = tight_options(tolerance);
  State before = rest_state(model), state = before;
  Residuals worst;
  int halved = 0;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& after) {
    REQUIRE(report.status == StepStatus::converged);
    if (report.retries == 0) {
      const Residuals found = residuals(model, options, before, after);
      // the solver's own figure is this one
      CHECK(std::max(found.stationarity, found.contact) <= report.kkt_residual * (1 + 1e-3) + 1e-9);
      keep_larger(worst, found);
    }
    halved += report.retries > 0;
    before = after;
  });
  CHECK(100 * halved <= steps);
  return worst;
}

void check_solved(const Residuals& worst, double tolerance = 1e-6) {
  CHECK(worst.stationarity <= tolerance);
  CHECK(worst.limit_excess <= tolerance);
  CHECK(worst.limit_complementarity <= tolerance);
  CHECK(worst.contact <= tolerance);
  CHECK(worst.penetration <= 1e-3);
}

}  // namespace

TEST_CASE("the reference hex: its force is the slope of its energy, and vanishes for a rigid motion") {
  test::Random random(3);
  const Matrix8x3d rest = test::box_nodes({0.5, 0.4, 0.7});
  const test::ReferenceHex hex = test::make_reference_hex(rest, 2e5, 0.3);
  for (int trial = 0; trial < 20; ++trial) {
    const test::NodesOf<double> x = test::deformed(rest, random, 0.05);
    const test::NodesOf<double> by_steps = test::reference_force_by_steps(hex, x);
    CHECK((test::reference_force(hex, x) - by_steps).norm() < 1e-12 * by_steps.norm());
    const Matrix24d hessian = test::reference_hessian(hex, x);
    CHECK((hessian - hessian.transpose()).norm() < 1e-12 * hessian.norm());
    const test::NodesOf<double> turned = test::affine(rest, random.rotation(), random.vector(2));
    CHECK(test::reference_energy(hex, turned) < 1e-20 * hex.lame_mu);
    CHECK(test::reference_force(hex, turned).norm() < 1e-12 * hex.lame_mu);
  }
}

TEST_CASE("a solution that is off in any of its parts is seen") {
  Body sphere = test::make_sphere(3, {0, 1.02, 0});
  sphere.velocity = {1, -4, 0};
  test::limit_energy(sphere, 20);
  const Model model = make_model({sphere}, {test::make_ground(0.3)});
  State before, state = rest_state(model);
  Workspace workspace(model);
  for (int i = 0; i < 4; ++i) {
    before = state;
    REQUIRE(step(model, tight_options(), workspace, state).status == StepStatus::converged);
  }
  const auto worst = [&](const State& after) {
    const Residuals found = residuals(model, tight_options(), before, after);
    return std::max({found.stationarity, found.limit_excess, found.limit_complementarity, found.contact});
  };
  REQUIRE(worst(state) <= 1e-6);
  REQUIRE(!state.contacts.empty());
  Eigen::Index hex = 0;
  REQUIRE(state.limit_multipliers.maxCoeff(&hex) > 0);

  State off = state;
  off.limit_multipliers[hex] *= 1 + 1e-4;
  CHECK(worst(off) > 1e-6);
  off = state;
  off.limit_multipliers[hex] = 0;
  CHECK(worst(off) > 1e-6);
  off = state;
  off.contacts[0].impulse *= 1 + 1e-4;
  CHECK(worst(off) > 1e-6);
  off = state;
  off.contacts.clear();
  CHECK(worst(off) > 1e-6);
  off = state;
  off.positions(model.hexes(hex, 0), 1) += 1e-5 * model.bodies[0].cell_size;
  CHECK(worst(off) > 1e-6);
}

TEST_CASE("every step of the limited beam is a solution to 1e-6, recomputed from the states") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  const Residuals worst = worst_of_run(beam, {}, 60);
  check_solved(worst);
  CHECK(worst.limits > 20);
}

TEST_CASE("every step of the damped beam is a solution to 1e-6, recomputed from the states") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.05);
  beam.material.damping_mass = 2;
  beam.material.damping_stiffness = 0.005;
  const Residuals worst = worst_of_run(beam, {}, 40);
  check_solved(worst);
  CHECK(worst.limits > 20);
}

TEST_CASE("every step of the sphere's impact with limits and friction is a solution to 1e-6") {
  Body sphere = test::make_sphere(3, {0, 1.1, 0});
  sphere.velocity = {1, -4, 0};
  sphere.spin = {0, 0, 2};
  sphere.friction = 0.5;
  test::limit_energy(sphere, 20);
  const Residuals worst = worst_of_run(sphere, {test::make_ground(0.3)}, 60);
  check_solved(worst);
  CHECK(worst.limits > 10);
  CHECK(worst.contacts > 2);
  CHECK(worst.sliding > 0);
  CHECK(worst.sticking > 0);
}

TEST_CASE("every step of a beam with limits on parts is a solution, recomputed from the states") {
  Body beam = test::make_beam();
  const auto hard = [](double stretch) {
    return EnergyLimitOptions{.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = stretch};
  };
  const auto limited = GENERATE(0, 1, 2, 3);
  CAPTURE(limited);
  PartLimitOptions& parts = beam.part_limits;
  parts.fibre_direction = {2, 1, 0};
  if (limited == 0) parts.volumetric = hard(0.07);
  if (limited == 1) parts.deviatoric = hard(0.07);
  if (limited == 2) parts.fibre = hard(0.07);
  if (limited == 3) parts.volumetric = hard(0.06), parts.fibre = hard(0.07), beam.limit = hard(0.08);
  const double tolerance = limited == 3 ? 1e-5 : 1e-6;  // three at once on a hex: harder to tell which ones hold
  const Residuals worst = worst_of_run(beam, {}, 40, tolerance);
  check_solved(worst, tolerance);
  CHECK(worst.limits > 10);
}

TEST_CASE("every step of a beam with peak limits is a solution, recomputed from the states") {
  Body beam = test::make_beam();
  const EnergyLimitOptions peak{.kind = LimitKind::hard, .value = 0.07, .measure = LimitMeasure::peak};
  const auto limited = GENERATE(0, 1);
  CAPTURE(limited);
  if (limited == 0) beam.limit = peak;
  if (limited == 1) beam.part_limits.fibre = peak;
  const Residuals worst = worst_of_run(beam, {}, 40, 1e-3);
  check_solved(worst, 1e-3);
  CHECK(worst.limits > 20);
}

TEST_CASE("every step of a block that lands, slides and stops is a solution to 1e-6") {
  Body block = test::make_block({3, 3, 3}, {0, 0.02, 0}, 0.1);
  block.material.young = 5e4;
  block.velocity = {0.6, -1, 0};
  block.friction = 0.4;
  test::limit_energy(block, 0.05);
  const Residuals worst = worst_of_run(block, {test::make_ground()}, 60);
  check_solved(worst);
  CHECK(worst.limits > 3);
  CHECK(worst.sliding > 0);
  CHECK(worst.sticking > 0);
}
