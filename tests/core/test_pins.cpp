// Pins: points of a body go where they are told, exactly or by springs, and the rest of it follows by the laws of motion.
#include "core/model/pins.h"

#include "core/step/step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/pinned_blocks.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

// points of a rod along x, thinner than a cell
std::vector<Vector3d> rod(const Vector3d& from, const Vector3d& to, double radius) {
  std::vector<Vector3d> points;
  for (int i = 0; i <= 12; ++i)
    for (int k = 0; k < 6; ++k) {
      const double angle = k * double(EIGEN_PI) / 3;
      points.push_back(from + i / 12.0 * (to - from) + radius * Vector3d(0, std::cos(angle), std::sin(angle)));
    }
  return points;
}

void swing(Pin& pin) {
  pin.motion.position.times = {0, 0.2, 0.5};
  pin.motion.position.values = {Vector3d(0, 0, 0), Vector3d(0.05, 0.1, 0), Vector3d(0, 0.05, 0.1)};
  pin.motion.rotation_degrees.times = {0, 0.5};
  pin.motion.rotation_degrees.values = {Vector3d(0, 0, 0), Vector3d(30, 40, 60)};
}

}  // namespace

TEST_CASE("pinned points follow a rigid motion within a millionth of a metre, however few or thin they are") {
  const Vector3i cells(4, 2, 2);
  Body body = soft_block(cells);
  std::vector<Vector3d> points;
  SECTION("a bone thinner than a cell") {
    points = rod({0.01, 0.07, 0.13}, {0.28, 0.07, 0.13}, 0.002);
  }
  SECTION("a bone so thin that it is a line") {
    points = rod({0.01, 0.07, 0.13}, {0.28, 0.07, 0.13}, 0);
  }
  SECTION("all points of some hexes") {
    for (int i = 0; i < 27; ++i)
      points.emplace_back(0.02 + 0.06 * (i % 3), 0.03 + 0.07 * (i / 3 % 3), 0.02 + 0.08 * (i / 9));
  }
  SECTION("a face") {
    for (int i = 0; i < 25; ++i) points.emplace_back(0.03, 0.05 * (i % 5), 0.05 * (i / 5));
  }
  SECTION("three points") {
    points = {{0.03, 0.02, 0.04}, {0.35, 0.18, 0.06}, {0.12, 0.11, 0.19}};
  }
  SECTION("one") {
    points = {{0.03, 0.02, 0.04}};
  }
  Pin pin = pin_at(body.lattice, cells, points);
  swing(pin);
  hold({pin}, body);
  const Model model = make_model({body}, {});
  State state = rest_state(model);
  simulate(model, StepOptions(), 36, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(miss(pin, model, now) < 1e-6);
  });
  // what is not pinned is free: it hangs and swings
  CHECK((state.positions - rest_state(model).positions).cwiseAbs().maxCoeff() > 0.05);
}

TEST_CASE("an animated mesh that moves rigidly holds what it was in at rest as keyframes do") {
  const Vector3i cells(4, 2, 2);
  Body body = soft_block(cells);
  const std::vector<Vector3d> points = rod({0.01, 0.07, 0.13}, {0.28, 0.07, 0.13}, 0.01);
  Pin keyed = pin_at(body.lattice, cells, points), animated = keyed;
  keyed.motion.rotation_degrees.times = {0, 1};
  keyed.motion.rotation_degrees.values = {Vector3d(0, 0, 0), Vector3d(0, 0, 90)};
  auto motion = std::make_shared<MeshMotion>();
  motion->num_vertices = keyed.rest.rows();
  for (int k = 0; k <= 60; ++k) {
    motion->times.push_back(k / 60.0);
    const Points at = targets_at(keyed, k / 60.0);
    for (const double value : at.reshaped<Eigen::RowMajor>()) motion->samples.push_back(float(value));
  }
  animated.motion.mesh = motion;
  animated.motion.corners.resize(keyed.rest.rows(), 3);
  animated.motion.shares = Points::Zero(keyed.rest.rows(), 3);
  animated.motion.shares.col(0).setOnes();
  for (int p = 0; p < int(keyed.rest.rows()); ++p) animated.motion.corners.row(p).setConstant(p);
  const auto end = [&](const Pin& pin) {
    Body pinned = body;
    hold({pin}, pinned);
    const Model model = make_model({pinned}, {});
    State state = rest_state(model);
    simulate(model, StepOptions(), 40, state, [&](const StepReport& report, const State& now) {
      CHECK(report.status == StepStatus::converged);
      CHECK(miss(pin, model, now) < 1e-6);
    });
    return state.positions;
  };
  CHECK((end(keyed) - end(animated)).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("a spring stretches by the weight that hangs on it") {
  const Vector3i cells(2, 2, 2);
  Body body = soft_block(cells);
  body.material.young = 1e7;
  body.material.damping_mass = 20;
  const double k = 2000;
  Pin pin = pin_at(body.lattice, cells, {{0.1, 0.2, 0.1}}, k);
  hold({pin}, body);
  const Model model = make_model({body}, {});
  State state = rest_state(model);
  simulate(model, StepOptions(), 300, state,
           [](const StepReport& report, const State&) { CHECK(report.status == StepStatus::converged); });
  CHECK(miss(pin, model, state) == Approx(total_mass(model) * 9.81 / k).epsilon(1e-3));
}

TEST_CASE("a pin holds from when it is told to until it lets go") {
  const Vector3i cells(2, 2, 2);
  Body body = soft_block(cells);
  Pin pin = pin_at(body.lattice, cells, {{0.03, 0.1, 0.1}, {0.17, 0.1, 0.1}, {0.1, 0.1, 0.17}, {0.1, 0.17, 0.1}});
  pin.until = 0.2;
  hold({pin}, body);
  const Model model = make_model({body}, {});
  State state = rest_state(model);
  simulate(model, StepOptions(), 60, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    if (now.time <= 0.2) CHECK(miss(pin, model, now) < 1e-6);
  });
  // it falls from then on
  const double fallen = 0.1 - mean_of(model.node_mass, state.positions).y();
  CHECK(fallen == Approx(0.5 * 9.81 * 0.8 * 0.8).epsilon(0.05));
}

TEST_CASE("pins that move a cell and more in a step are followed in several, without an explosion") {
  const Vector3i cells(4, 2, 2);
  Body body = soft_block(cells);
  limit_energy(body, 2);
  std::vector<Vector3d> points;
  for (int i = 0; i < 27; ++i)
    points.emplace_back(0.01 + 0.04 * (i % 3), 0.03 + 0.07 * (i / 3 % 3), 0.02 + 0.08 * (i / 9));
  Pin pin = pin_at(body.lattice, cells, points);
  pin.motion.position.times = {0, 0.05};
  pin.motion.position.values = {Vector3d(0, 0, 0), Vector3d(-0.6, 0, 0)};  // two cells a step
  hold({pin}, body);
  const Model model = make_model({body}, {});
  State state = rest_state(model);
  int most = 0;
  simulate(model, without_gravity(), 40, state, [&](const StepReport& report, const State& now) {
    most = std::max(most, report.substeps);
    CHECK(miss(pin, model, now) < 1e-6);
    CHECK(now.positions.rowwise().norm().maxCoeff() < 3);
  });
  CHECK(most > 4);
  CHECK(state.positions.col(0).mean() == Approx(-0.4).margin(0.15));
}

TEST_CASE("driven nodes are the same for factors and multigrids, and steps the same bytes for a new workspace") {
  const Vector3i cells(6, 3, 3);
  Body body = soft_block(cells);
  body.surface = {};
  body.surface.weights.resize(0, 8);
  body.surface_rest.resize(0, 3);
  std::vector<Vector3d> points;
  for (int i = 0; i < 36; ++i)
    for (const double x : {0.02, 0.07}) points.emplace_back(x, 0.025 + 0.05 * (i % 6), 0.025 + 0.05 * (i / 6));
  Pin pin = pin_at(body.lattice, cells, points);
  swing(pin);
  pin.from = 0.1;
  hold({pin}, body);
  Body held = body;
  held.fixed_nodes = {0};  // beside it
  const Model model = make_model({held}, {});
  const auto end = [&](LinearSolver linear, bool anew) {
    StepOptions options;
    options.solver.linear = linear;
    options.solver.tolerance = 1e-6;
    State state = rest_state(model);
    auto workspace = std::make_unique<Workspace>(model);
    for (int i = 0; i < 20; ++i) {
      if (anew) workspace = std::make_unique<Workspace>(model);
      CHECK(step(model, options, *workspace, state).status == StepStatus::converged);
    }
    return state.positions;
  };
  const Points direct = end(LinearSolver::direct, false);
  CHECK(direct == end(LinearSolver::direct, true));
  CHECK((direct - end(LinearSolver::multigrid, false)).cwiseAbs().maxCoeff() < 1e-4);
}
