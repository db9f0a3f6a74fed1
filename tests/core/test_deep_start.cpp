// Bodies that start inside each other.
#include <cmath>

#include "core/contact/held_vertex.h"
#include "core/contact/surface_contact.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

// [m/s] at which bodies are pushed apart where nothing falls: a hundredth of the speed of sound
double recovery_of(double young, double density) {
  return 0.01 * std::sqrt(young / density);
}

}  // namespace

TEST_CASE("bodies inside each other at the start are found, and pushed apart gently") {
  Body left = touchable_block("left", {2, 2, 2}, {0, 0, 0}, 0.1);
  Body right = touchable_block("right", {2, 2, 2}, {0.17, 0, 0}, 0.1);  // 3 cm inside
  const Model model = make_model({left, right}, {});
  const std::vector<Overlap> overlaps = find_overlaps(model, rest_state(model));
  REQUIRE(overlaps.size() == 2);
  CHECK(overlaps[0].depth == Approx(0.03).epsilon(1e-6));
  CHECK(overlaps[0].vertices >= 49);  // 7 x 7 of its end; others lie on sides that both have in one plane
  State state = rest_state(model);
  test::simulate(model, without_gravity(), 60, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(test::momentum(model, now).norm() < 1e-8 * test::total_mass(model));
    CHECK(now.velocities.rowwise().norm().maxCoeff() < 2);
  });
  CHECK(find_overlaps(model, state).empty());
}

TEST_CASE("bodies of different cells that start inside each other are pushed apart at the speed of recovery") {
  const double aside = GENERATE(0.0, 0.013);  // 0: their sides lie in one plane
  const bool clamped = GENERATE(false, true);
  CAPTURE(aside, clamped);
  Body low = touchable_block("low", {2, 2, 2}, {0, 0, 0}, 0.1, 8);
  Body high = touchable_block("high", {3, 3, 3}, {aside, 0.18, aside}, 0.2 / 3, 8);  // 2 cm inside
  for (int node = 0; clamped && node < int(low.lattice.num_nodes()); ++node)
    if (low.lattice.rest_positions(node, 1) < 1e-9) low.fixed_nodes.push_back(node);
  for (int node = 0; clamped && node < int(high.lattice.num_nodes()); ++node)
    if (high.lattice.rest_positions(node, 1) > 0.38 - 1e-9) high.fixed_nodes.push_back(node);
  const Model model = make_model({low, high}, {});
  const double recovery = recovery_of(500e3, 1000);
  State state = rest_state(model);
  simulate(model, without_gravity(), 30, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.retries == 0);
    if (!clamped) CHECK(momentum(model, now).norm() < 1e-8 * total_mass(model));
    CHECK(now.velocities.rowwise().norm().maxCoeff() < 1.5 * recovery);
    CHECK(report.kinetic_energy < 0.5 * total_mass(model) * recovery * recovery);
  });
  CHECK(find_overlaps(model, state).empty());
}

TEST_CASE("limbs that start across each other's middle leave by one side, gently") {
  // The nearest way out of one half of a limb is up, of the other one down: together they would tear it apart.
  const double aside = GENERATE(0.0, 0.004), above = GENERATE(0.0, 0.006);
  CAPTURE(aside, above);
  const Body along_x = touchable_block("x", {7, 1, 1}, {-0.175, -0.025, -0.025}, 0.05, 8);
  const Body along_z = touchable_block("z", {1, 1, 7}, {-0.025 + aside, -0.025 + above, -0.175}, 0.05, 8);
  const Model model = make_model({along_x, along_z}, {});
  State state = rest_state(model);
  REQUIRE(find_overlaps(model, state).size() == 2);
  const double recovery = recovery_of(500e3, 1000);
  int steps_inside = 0;
  simulate(model, without_gravity(), 60, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.retries == 0);
    CHECK(report.max_energy_ratio < 1);
    CHECK(momentum(model, now).norm() < 1e-8 * total_mass(model));
    CHECK(report.kinetic_energy < 1.05 * 0.5 * total_mass(model) * recovery * recovery);  // they swing a little
    if (!find_overlaps(model, now).empty()) ++steps_inside;
  });
  CHECK(find_overlaps(model, state).empty());
  CHECK(steps_inside >= 5);   // at once would be a bang
  CHECK(steps_inside <= 14);  // 5 cm at 0.22 m/s
}

TEST_CASE("a vertex that started outside may not stay in a body that has turned, which sees it come from within") {
  const Model model = make_model(
      {touchable_block("bar", {4, 1, 1}, {0, 0, 0}, 0.1), touchable_block("cube", {1, 1, 1}, {0, 0, 0}, 0.1)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  const Model::BodyRange &bar = model.bodies[0], &cube = model.bodies[1];
  const int vertex = cube.first_point, tip = bar.first_hex + 3;
  const Contact contact = make_surface_contact(model, vertex, surface_hex(model, vertex), tip);
  const auto with_vertex_at = [&](const Vector3d& place) {
    Points positions = model.rest_positions;
    const Vector3d by = place - embedded_position(model, positions, contact.support);
    positions.middleRows(cube.first_node, cube.num_nodes).rowwise() += by.transpose();
    return positions;
  };
  // 5 cm above the bar's end; then in that end, which a quarter turn about z has taken down
  const Points start = with_vertex_at({0.395, 0.15, 0.05});
  Points now = with_vertex_at({0.05, -0.395, 0.05});
  for (int node = bar.first_node; node < bar.first_node + bar.num_nodes; ++node) {
    const Eigen::RowVector3d rest = now.row(node);
    now.row(node) << rest.y(), -rest.x(), rest.z();
  }
  const ContactStep step = begin_contact_step(model, geometry, start, now, 0, 0.01, 9.81);
  HeldVertex held;
  REQUIRE(hold(model, start, contact.support, embedded_position(model, now, contact.support), hex_maps(model, now, tip),
               within_hex, held));
  // as the turned end sees where the vertex came from: in the bar's middle
  REQUIRE((held.X0 - Vector3d(0.295, 0.05, 0.05)).norm() < 1e-9);
  CHECK(allowance(step, held).deep == 0);
}
