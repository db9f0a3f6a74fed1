// Pins: points of a body go where they are told, exactly or by springs, and the rest of it follows by the laws of motion.
#include "core/model/pins.h"

#include "core/step/step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// points of a box lattice as a pin that does not move yet
Pin pin_at(const Lattice& lattice, const Vector3i& num_cells, const std::vector<Vector3d>& places,
           double stiffness = infinity) {
  Pin pin;
  pin.name = "pin";
  pin.rest = as_points(places);
  pin.points = embed_in_box(lattice, num_cells, pin.rest);
  pin.part = VectorXi::Zero(pin.rest.rows());
  pin.stiffness = VectorXd::Constant(pin.rest.rows(), stiffness);
  pin.motion.pivot = pin.rest.colwise().mean().transpose();
  return pin;
}

void hold(std::vector<Pin> pins, Body& body) {
  body.pins = std::make_shared<const BodyPins>(std::move(pins), body.lattice.rest_positions, body.lattice.hexes);
}

// the farthest of the pin's points from where they should be [m]
double miss(const Pin& pin, const Model& model, const State& state) {
  const Points targets = targets_at(pin, state.time);
  double farthest = 0;
  for (Eigen::Index p = 0; p < targets.rows(); ++p) {
    Vector3d place = Vector3d::Zero();
    for (int n = 0; n < 8; ++n)
      place += pin.points.weights(p, n) * state.positions.row(model.hexes(pin.points.hex[p], n)).transpose();
    farthest = std::max(farthest, (place - targets.row(p).transpose()).norm());
  }
  return farthest;
}

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

// of a bar of 2 x 2 cells: by all of the end's hexes' nodes, or by a point in each of these hexes
std::vector<Vector3d> points_at_end(double x, bool driven) {
  std::vector<Vector3d> points;
  for (int i = 0; i < (driven ? 32 : 4); ++i)
    points.emplace_back(driven ? Vector3d(x + 0.05 * (i % 2), 0.025 + 0.05 * (i / 2 % 4), 0.025 + 0.05 * (i / 8))
                               : Vector3d(x, 0.04 + 0.11 * (i % 2), 0.06 + 0.1 * (i / 2)));
  return points;
}

Body soft_block(const Vector3i& cells) {
  Body body = make_block(cells, {0, 0, 0}, 0.1, 2);
  body.material.young = 100e3;
  return body;
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
