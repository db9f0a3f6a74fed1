// Pins against limits: what pins stretch beyond a limit, what it costs, and how it comes back when they let go.
#include "core/step/step.h"
#include "tests/support/catch.h"
#include "tests/support/pinned_blocks.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

// of a bar of 2 x 2 cells: by all of the end's hexes' nodes, or by a point in each of these hexes
std::vector<Vector3d> points_at_end(double x, bool driven) {
  std::vector<Vector3d> points;
  for (int i = 0; i < (driven ? 32 : 4); ++i)
    points.emplace_back(driven ? Vector3d(x + 0.05 * (i % 2), 0.025 + 0.05 * (i / 2 % 4), 0.025 + 0.05 * (i / 8))
                               : Vector3d(x, 0.04 + 0.11 * (i % 2), 0.06 + 0.1 * (i / 2)));
  return points;
}

}  // namespace

TEST_CASE("pins beat limits: only then is a limit exceeded, it is said, and the body comes back unharmed") {
  const Vector3i cells(6, 2, 2);
  Body body = soft_block(cells);
  limit_energy(body, 0.05);
  const auto block_of = [&](double x) {  // in each hex of a layer
    std::vector<Vector3d> points;
    for (int i = 0; i < 32; ++i)
      points.emplace_back(x + 0.05 * (i % 2), 0.025 + 0.05 * (i / 2 % 4), 0.025 + 0.05 * (i / 8));
    return points;
  };
  // all of these hexes' nodes are led, or one point holds what springs hold
  const bool few = GENERATE(false, true);
  CAPTURE(few);
  Pin left = pin_at(body.lattice, cells, block_of(0.02)),
      right = pin_at(body.lattice, cells,
                     few ? std::vector<Vector3d>{{0.55, 0.04, 0.1}, {0.56, 0.15, 0.11}} : block_of(0.52));
  right.motion.position.times = {0, 0.3, 0.5, 0.8};
  right.motion.position.values = {Vector3d(0, 0, 0), Vector3d(0.5, 0, 0), Vector3d(0.5, 0, 0), Vector3d(0, 0, 0)};
  hold({left, right}, body);
  const Model model = make_model({body}, {});
  StepOptions options = without_gravity();
  State state = rest_state(model);
  double largest = 0;
  int infeasible = 0;
  simulate(model, options, 90, state, [&](const StepReport& report, const State& now) {
    CHECK(now.positions.allFinite());
    CHECK(miss(left, model, now) < 1e-6);
    CHECK(miss(right, model, now) < 1e-6);
    if (report.status != StepStatus::infeasible) CHECK(report.max_energy_ratio <= 1 + 1.1e-3);
    infeasible += report.status == StepStatus::infeasible;
    largest = std::max(largest, report.max_energy_ratio);
    CHECK(now.positions.rowwise().norm().maxCoeff() < 2);
  });
  CHECK(largest > 2);
  CHECK(infeasible > 10);
  CHECK(infeasible < 60);
  CHECK((state.positions - rest_state(model).positions).cwiseAbs().maxCoeff() < 0.05);
}

TEST_CASE("a body that pins tear to three times its length gives way at the cost of a few steps, and comes to rest") {
  const bool driven = GENERATE(false, true);  // all nodes of the ends' hexes, or one point in each of them, by springs
  CAPTURE(driven);
  const Vector3i cells(8, 2, 2);
  Body body = soft_block(cells);
  limit_energy(body, 0.05);
  const Pin left = pin_at(body.lattice, cells, points_at_end(0.02, driven));
  Pin right = pin_at(body.lattice, cells, points_at_end(0.72, driven));
  constexpr double stands_at = 0.3;  // [s]
  right.motion.position.times = {0, stands_at};
  right.motion.position.values = {Vector3d(0, 0, 0), Vector3d(1.6, 0, 0)};
  hold({left, right}, body);
  const Model model = make_model({body}, {});
  const StepOptions options = without_gravity();
  State state = rest_state(model);
  int torn = 0, iterations = 0;
  double kinetic = 0, total = 0;  // [J] once the pins stand still
  simulate(model, options, 60, state, [&](const StepReport& report, const State& now) {
    CHECK(miss(left, model, now) < 1e-6);
    CHECK(miss(right, model, now) < 1e-6);
    CHECK(report.retries == 0);
    if (report.status != StepStatus::infeasible) CHECK(report.max_energy_ratio <= 1.001);
    const double sum = report.kinetic_energy + report.elastic_energy;
    if (now.time > stands_at + 3 * options.time_step) {
      CHECK(report.kinetic_energy <= kinetic + 1e-3 * total);
      CHECK(sum <= total * (1 + 1e-3));
    } else {
      kinetic = report.kinetic_energy;
    }
    total = sum;
    if (report.max_energy_ratio < 3) return;
    ++torn;
    iterations += report.sqp_iterations;
    if (torn > 1) CHECK(report.sqp_iterations <= 60);
  });
  CHECK(torn > 40);
  CHECK(iterations < 25 * torn);
  CHECK(kinetic < 50);
}

TEST_CASE("a body that pins have torn comes back when they let go, and is not thrown") {
  const bool both = GENERATE(false, true);  // let go; or one of them alone
  const bool driven = GENERATE(false, true);
  CAPTURE(both, driven);
  const Vector3i cells(8, 2, 2);
  Body body = soft_block(cells);
  limit_energy(body, 0.05);
  constexpr double lets_go_at = 0.495;  // [s]
  Pin left = pin_at(body.lattice, cells, points_at_end(0.02, driven)),
      right = pin_at(body.lattice, cells, points_at_end(0.72, driven));
  right.motion.position.times = {0, 0.3};
  right.motion.position.values = {Vector3d(0, 0, 0), Vector3d(1.6, 0, 0)};
  right.until = lets_go_at;
  if (both) left.until = lets_go_at;
  hold({left, right}, body);
  const Model model = make_model({body}, {});
  const StepOptions options = without_gravity();
  State state = rest_state(model);
  double total = 0;
  int beyond = 0;
  simulate(model, options, 150, state, [&](const StepReport& report, const State& now) {
    const double sum = report.kinetic_energy + report.elastic_energy;
    if (now.time > lets_go_at) {
      CHECK(sum <= total * (1 + 1e-3) + 1e-6);
      CHECK(report.sqp_iterations <= 60);
      CHECK(report.retries == 0);
      if (report.max_energy_ratio > 1.001) CHECK(report.status == StepStatus::infeasible);
      if (report.max_energy_ratio <= 1.001) CHECK(report.status == StepStatus::converged);
      beyond += report.max_energy_ratio > 1.001;
    }
    total = sum;
  });
  CHECK(beyond > 0);
  CHECK(beyond < 30);
  CHECK(energy_ratios(model, options.solver, state).maxCoeff() <= 1.001);
}

TEST_CASE("a weight that has been let go is drawn up to the limit slowly") {
  const Vector3i cells(8, 2, 2);
  Body body = soft_block(cells);
  limit_energy(body, 0.05);
  constexpr double lets_go_at = 0.495;  // [s]
  const Pin left = pin_at(body.lattice, cells, points_at_end(0.02, true));
  Pin right = pin_at(body.lattice, cells, points_at_end(0.72, true));
  right.motion.position.times = {0, 0.3};
  right.motion.position.values = {Vector3d(0, 0, 0), Vector3d(0.4, 0, 0)};
  right.until = lets_go_at;
  hold({left, right}, body);
  const Model model = make_model({body}, {});
  StepOptions options = without_gravity();
  options.gravity = {100, 0, 0};  // stretches the bar beyond its limits by itself
  State state = rest_state(model);
  const double length = body.lattice.rest_positions.col(0).maxCoeff();
  double last = 0;
  int infeasible = 0;
  simulate(model, options, 90, state, [&](const StepReport& report, const State& now) {
    const double end = now.positions.col(0).maxCoeff();
    if (now.time > lets_go_at + 0.1) CHECK(last - end < 0.55 * length * options.time_step);
    if (now.time > lets_go_at) infeasible += report.status == StepStatus::infeasible;
    last = end;
  });
  CHECK(infeasible > 5);
  CHECK(infeasible < 55);
  CHECK(energy_ratios(model, options.solver, state).maxCoeff() <= 1.001);
  CHECK(energy_ratios(model, options.solver, state).maxCoeff() > 0.99);
}

TEST_CASE("a pin that pulls into the ground beats no limit for nothing") {
  const Vector3i cells(3, 2, 3);
  Body body = soft_block(cells);
  limit_energy(body, 0.05);
  Pin pin = pin_at(body.lattice, cells, {{0.15, 0, 0.15}});
  pin.motion.position.times = {0, 0.2};
  pin.motion.position.values = {Vector3d(0, 0, 0), Vector3d(0, -0.02, 0)};
  hold({pin}, body);
  const Model model = make_model({body}, {make_ground()});
  State state = rest_state(model);
  double farthest = 0;
  simulate(model, StepOptions(), 20, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.001);
    farthest = std::max(farthest, miss(pin, model, now));
  });
  CHECK(farthest > 0.015);  // the ground wins
}
