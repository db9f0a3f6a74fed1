// The exact method: the paper's beam against independent numbers, limits that hold, soft limits, halved steps.
#include <Eigen/LU>
#include <limits>
#include <map>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

StepOptions exact_options(double tolerance = 1e-3) {
  StepOptions options{.time_step = 0.01};
  options.solver.method = SolverMethod::exact;
  options.solver.tolerance = tolerance;
  return options;
}

struct Swing {
  double lowest_tip = 0, last_tip = 0;  // [m] of the free end's centre, against rest
  double highest_ratio = 0, highest_residual = 0;
  int factorisations = 0, steps = 0, retried_steps = 0;
};

Swing swing(const Body& beam, const StepOptions& options, int steps) {
  const Model model = make_model({beam}, {});
  State state = rest_state(model);
  Swing result;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& now) {
    const int tip = test::beam_tip();
    result.last_tip = now.positions(tip, 1) - model.rest_positions(tip, 1);
    result.lowest_tip = std::min(result.lowest_tip, result.last_tip);
    result.highest_ratio = std::max(result.highest_ratio, report.max_energy_ratio);
    result.highest_residual = std::max(result.highest_residual, report.kkt_residual);
    result.factorisations += report.factorisations;
    ++result.steps;
    CHECK(report.status == StepStatus::converged);
    result.retried_steps += report.retries > 0;
  });
  CHECK(100 * result.retried_steps <= result.steps);
  return result;
}

}  // namespace

TEST_CASE("the limited beam's first swing is the one that four other methods agree on") {
  for (const auto& [limit, tip] : std::map<double, double>{{1, -0.946}, {0.1, -0.714}, {0.01, -0.296}}) {
    CAPTURE(limit);
    Body beam = test::make_beam();
    test::limit_energy(beam, limit);
    const Swing result = swing(beam, exact_options(), 80);
    CHECK(result.lowest_tip == Approx(tip).margin(2e-3));
    CHECK(result.highest_ratio <= 1.001);
    CHECK(result.highest_residual <= 1e-3);
    CHECK(result.factorisations <= 4 * result.steps);
  }
}

TEST_CASE("a tight tolerance is met: limits and residual to 1e-6") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  const Swing result = swing(beam, exact_options(1e-6), 60);
  CHECK(result.highest_ratio <= 1 + 1e-6);
  CHECK(result.highest_residual <= 1e-6);
}

TEST_CASE("the limited beam settles where the static problem has its solution") {
  for (const auto& [limit, tip] : std::map<double, double>{{0.1, -0.6736}, {0.05, -0.5528}, {0.01, -0.2871}}) {
    CAPTURE(limit);
    Body beam = test::make_beam();
    test::limit_energy(beam, limit);
    beam.material.damping_mass = 4;
    StepOptions options = exact_options();
    options.time_step = 0.02;
    CHECK(swing(beam, options, 250).last_tip == Approx(tip).margin(1e-3));
  }
}

TEST_CASE("a soft limit stiffens the beam before the limit and lets it pass by little") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  const double hard = swing(beam, exact_options(), 60).lowest_tip;
  beam.limit.kind = LimitKind::soft;
  const Model model = make_model({beam}, {});
  State state = rest_state(model);
  double lowest = 0, highest = 0;
  test::simulate(model, exact_options(), 60, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    lowest = std::min(lowest, now.positions(test::beam_tip(), 1) - model.rest_positions(test::beam_tip(), 1));
    for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, RotationEstimate::centre, hex_nodes(model, now.positions, e));
      highest = std::max(highest, elastic_energy(shape.stiffness, young_at(model, e, now.time), hex) / 0.1);
    }
  });
  CHECK(highest > 0.8);
  CHECK(highest < 1.02);
  CHECK(lowest == Approx(hard).margin(0.05));
}

namespace {

Model tight_beam() {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.01);
  return make_model({beam}, {});
}

// under which its steps are halved
StepOptions few_iterations() {
  StepOptions options = exact_options();
  options.time_step = 0.05;
  options.solver.max_newton_iterations = 3;
  options.solver.max_augmented_iterations = 0;
  return options;
}

}  // namespace

TEST_CASE("a step that cannot converge in its iterations is halved, reported, and ends on time") {
  const Model model = tight_beam();
  StepOptions options = few_iterations();
  options.solver.max_halvings = 8;
  State state = rest_state(model);
  int retries = 0;
  test::simulate(model, options, 20, state, [&](const StepReport& report, const State&) {
    retries += report.retries;
    if (report.status == StepStatus::converged) CHECK(report.max_energy_ratio <= 1.001);
  });
  CHECK(retries > 0);
  CHECK(state.time == Approx(20 * 0.05).epsilon(1e-12));
}

TEST_CASE("what is thrown in the middle of a step leaves its state as it was") {
  const Model model = tight_beam();
  StepOptions options = few_iterations();
  State state = rest_state(model), solved = state;
  Workspace workspace(model), interrupted(model);
  for (int i = 0; i < 10; ++i) {
    int iterations = 0;
    options.on_iteration = [&](const IterationReport&) { ++iterations; };
    step(model, options, workspace, solved);
    const State before = state;
    options.on_iteration = [&](const IterationReport&) {
      if (--iterations == 0) throw i;  // the last one
    };
    CHECK_THROWS_AS(step(model, options, interrupted, state), int);
    CHECK(state.positions == before.positions);
    CHECK(state.velocities == before.velocities);
    CHECK(state.time == before.time);
    options.on_iteration = {};
    step(model, options, interrupted, state);
    CHECK(state.positions == solved.positions);
  }
}

TEST_CASE("limits that an impact loads and unloads are found in few iterations") {
  Body block = test::make_block({6, 6, 6}, {0, 0.05, 0}, 0.05);
  block.material.young = Track<double>(100e3);
  block.limit.kind = LimitKind::hard;
  block.limit.unit = LimitUnit::stretch;
  block.limit.value = Track<double>(0.2);
  block.velocity = {2, -6, 0};
  block.spin = {0, 0, 3};
  const Model model = make_model({block}, {test::make_ground(0.6)});
  StepOptions options = exact_options();
  options.time_step = 1.0 / 60;
  State state = rest_state(model);
  int iterations = 0, active = 0;
  test::simulate(model, options, 12, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    iterations += report.sqp_iterations;
    active = std::max(active, report.limits_active);
  });
  CHECK(active > 20);
  CHECK(iterations <= 60);  // 259 where limits that would pull are held until they are loosened
}

TEST_CASE("multipliers that an impact changes settle at once in very short steps, too") {
  Body block = test::make_block({3, 3, 3}, {0, 0.001, 0}, 0.2);
  block.material.young = Track<double>(20e3);
  block.limit.kind = LimitKind::hard;
  block.limit.unit = LimitUnit::stretch;
  block.limit.value = Track<double>(0.05);
  block.velocity = {1, -3, 0};
  block.spin = {0, 0, 2};
  const Model model = make_model({block}, {test::make_ground(0.5)});
  StepOptions options = exact_options();
  options.time_step = 1.0 / 6000;
  State state = rest_state(model);
  int iterations = 0, active = 0;
  test::simulate(model, options, 300, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.retries == 0);
    iterations += report.sqp_iterations;
    active = std::max(active, report.limits_active);
  });
  CHECK(active > 5);
  CHECK(iterations <= 700);  // 19,645 with a penalty that does not know the inertia
}

TEST_CASE("a free fall is solved before the first iteration, however far a step moves the body") {
  Body block = test::make_block({2, 2, 2}, {0, 100, 0}, 0.1);
  block.velocity = {1, -30, 0};
  block.material.damping_mass = 0.5;
  const Model model = make_model({block}, {test::make_ground()});
  State state = rest_state(model);
  test::simulate(model, exact_options(), 10, state, [](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.sqp_iterations == 0);
  });
}

TEST_CASE("where the SQP gives up, the line search finds the same steps") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.1);
  StepOptions options = exact_options();
  const Swing usual = swing(beam, options, 60);
  options.solver.max_newton_iterations = 1;
  options.solver.max_halvings = 0;
  const Swing searched = swing(beam, options, 60);
  CHECK(searched.highest_ratio <= 1.001);
  CHECK(searched.highest_residual <= 1e-3);
  CHECK(searched.last_tip == Approx(usual.last_tip).margin(2e-3));
  CHECK(searched.lowest_tip == Approx(usual.lowest_tip).margin(2e-3));
}

TEST_CASE("the line search solves limits, contact and friction together") {
  Body sphere = test::make_sphere(3, {0, 1.05, 0});
  test::limit_energy(sphere, 20);
  sphere.velocity = {1, -4, 0};
  sphere.friction = 0.5;
  const Model model = make_model({sphere}, {test::make_ground(0.5)});
  StepOptions options = exact_options();
  const State usual = test::simulate(model, options, 15);
  options.solver.max_newton_iterations = 1;
  options.solver.max_halvings = 0;
  State searched = rest_state(model);
  test::simulate(model, options, 15, searched, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.001);
    CHECK(report.kkt_residual <= 1e-3);
  });
  CHECK((searched.positions - usual.positions).cwiseAbs().maxCoeff() < 5e-3);
}

namespace {

// a cube of 4 x 4 x 4 hexes whose nodes start where `place` puts them; limited to 20 % stretch, nothing else acts
struct Recovery {
  bool finite = true, been_feasible = false, limits_held = true;
  double shape_error = 0;  // RMS node distance after rigid alignment, over the diagonal
  double smallest_det = 0;
};

double shape_error(const Points& rest, const Points& positions) {
  const Points a = rest.rowwise() - rest.colwise().mean(), b = positions.rowwise() - positions.colwise().mean();
  const Matrix3d rotation = polar_rotation(b.transpose() * a);
  const double diagonal = (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm();
  return std::sqrt((b - a * rotation.transpose()).rowwise().squaredNorm().mean()) / diagonal;
}

double smallest_det(const Model& model, const Points& positions) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d local(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      Matrix8x3d slopes;  // of the shape functions, by central differences (exact: they are linear in each coordinate)
      for (int axis = 0; axis < 3; ++axis)
        slopes.col(axis) =
            0.5 * (shape_functions(local + Vector3d::Unit(axis)) - shape_functions(local - Vector3d::Unit(axis)));
      const Matrix3d now = hex_nodes(model, positions, e).transpose() * slopes;
      const Matrix3d rest = hex_nodes(model, model.rest_positions, e).transpose() * slopes;
      smallest = std::min(smallest, (now * rest.inverse()).determinant());
    }
  return smallest;
}

Recovery recover(const std::function<Vector3d(const Vector3d&)>& place) {
  Body cube = test::make_block({4, 4, 4}, Vector3d::Constant(-0.5), 0.25);
  cube.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
  const Model model = make_model({cube}, {});
  StepOptions options;
  options.gravity.setZero();
  State state = rest_state(model);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    state.positions.row(node) = place(model.rest_positions.row(node).transpose()).transpose();
  Recovery recovery;
  test::simulate(model, options, 120, state, [&](const StepReport& report, const State& now) {
    recovery.finite = recovery.finite && now.positions.allFinite() && now.velocities.allFinite();
    if (!now.been_feasible) CHECK(report.status == StepStatus::infeasible);
    if (now.been_feasible) recovery.limits_held = recovery.limits_held && report.max_energy_ratio <= 1.001;
  });
  recovery.been_feasible = state.been_feasible;
  recovery.shape_error = shape_error(model.rest_positions, state.positions);
  recovery.smallest_det = smallest_det(model, state.positions);
  return recovery;
}

struct Random {
  unsigned state;
  double operator()() {  // -0.5 ... 0.5
    state = state * 1664525u + 1013904223u;
    return double(state >> 8) / double(1u << 24) - 0.5;
  }
  Vector3d vector() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }
};

// of `seeds` starts of each kind, how many end within 5 % of the rest shape and nowhere inverted
void check_recoveries(unsigned seeds) {
  std::map<std::string, unsigned> recovered;
  const auto count = [&](const std::string& kind, const Recovery& recovery) {
    CHECK(recovery.finite);
    CHECK(recovery.limits_held);
    recovered[kind] += recovery.been_feasible && recovery.shape_error <= 0.05 && recovery.smallest_det > 0;
  };
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random{seed * 7919 + 13};
    for (int i = 0; i < 5; ++i) random();
    const Vector3d point = random.vector(), normal = random.vector().normalized();
    count("random", recover([&](const Vector3d&) { return random.vector(); }));
    count("plane", recover([&](const Vector3d& x) { return Vector3d(x - normal * normal.dot(x)); }));
    count("point", recover([&](const Vector3d&) { return point; }));
    count("mirrored", recover([&](const Vector3d& x) { return Vector3d(x - 2 * normal * normal.dot(x)); }));
  }
  for (const auto& [kind, number] : recovered) {
    CAPTURE(kind);
    CHECK(number == seeds);
  }
}

}  // namespace

TEST_CASE("a body that starts crumpled, flat, in a point or mirrored recovers its shape and then keeps its limits") {
  check_recoveries(2);
}

TEST_CASE("forty crumpled, flat, collapsed and mirrored starts all recover", "[slow]") {
  check_recoveries(10);
}
