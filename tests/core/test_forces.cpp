// Forces from outside on nodes: closed forms, with both linear solvers and both methods.
#include <algorithm>
#include <limits>

#include "core/step/step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;

namespace {

struct Method {
  SolverMethod method;
  LinearSolver linear;
};

const Method direct{SolverMethod::exact, LinearSolver::direct}, multigrid{SolverMethod::exact, LinearSolver::multigrid},
    paper{SolverMethod::paper, LinearSolver::direct};

StepOptions options_with(const Method& method) {
  StepOptions options{.time_step = 0.01, .gravity = Vector3d::Zero()};
  options.solver.method = method.method;
  options.solver.linear = method.linear;
  return options;
}

// each node's mass times this acceleration [N]
Points accelerating(const Model& model, const Vector3d& acceleration) {
  return model.node_mass * acceleration.transpose();
}

// a force [N] spread evenly over the faces at the block's far end in x
Points pull_at_end(const Model& model, const Vector3d& force) {
  const double end = model.rest_positions.col(0).maxCoeff();
  Points forces = Points::Zero(model.num_nodes(), 3);
  double corners = 0;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n)
      if (const int node = model.hexes(e, n); model.rest_positions(node, 0) > end - 1e-9) {
        forces.row(node) += force.transpose();
        ++corners;
      }
  return forces / corners;
}

// 4 x 2 x 2 cells of 0.25 m, clamped at x = 0, that do not narrow when they are pulled
Body clamped_bar() {
  Body bar = test::make_block({4, 2, 2}, {0, 0, 0}, 0.25);
  bar.material.poisson = 0;
  bar.material.damping_mass = 20;
  for (Eigen::Index node = 0; node < bar.lattice.num_nodes(); ++node)
    if (bar.lattice.rest_positions(node, 0) < 1e-9) bar.fixed_nodes.push_back(int(node));
  return bar;
}

}  // namespace

TEST_CASE("forces in proportion to mass let a free body fall as implicit Euler falls") {
  const Method method = GENERATE(direct, multigrid, paper);
  const Model model = make_model({test::make_block({3, 3, 3}, {0, 1, 0}, 0.1)}, {});
  const Vector3d acceleration(3, -7, 2);
  StepOptions options = options_with(method);
  options.forces = accelerating(model, acceleration);
  State state = rest_state(model);
  const double h = options.time_step;
  test::simulate(model, options, 10, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    const auto n = double(now.step);
    const Eigen::RowVector3d fallen = h * h * n * (n + 1) / 2 * acceleration.transpose();
    CHECK(((now.positions - model.rest_positions).rowwise() - fallen).cwiseAbs().maxCoeff() < 1e-10);
  });
}

TEST_CASE("a bar that is pulled at its end lengthens by F L / (Y A)") {
  const Method method = GENERATE(direct, multigrid, paper);
  const Body bar = clamped_bar();
  const Model model = make_model({bar}, {});
  const double force = 2000, length = 1, area = 0.25, young = bar.material.young.at(0);
  StepOptions options = options_with(method);
  options.solver.tolerance = 1e-6;
  options.forces = pull_at_end(model, {force, 0, 0});
  const State state = test::simulate(model, options, 300);
  const double lengthened = state.positions.col(0).maxCoeff() - length;
  CHECK(lengthened == Approx(force * length / (young * area)).epsilon(1e-4));
  // every section as much, and nothing sideways
  const Points motion = state.positions - model.rest_positions;
  CHECK((motion.col(0) - lengthened * model.rest_positions.col(0)).cwiseAbs().maxCoeff() < 1e-4 * lengthened);
  CHECK(motion.rightCols(2).cwiseAbs().maxCoeff() < 1e-4 * lengthened);
}

TEST_CASE("a limit holds against a force that would stretch the bar far beyond it") {
  const Method method = GENERATE(direct, multigrid);
  Body bar = clamped_bar();
  bar.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.05};
  const Model model = make_model({bar}, {});
  StepOptions options = options_with(method);
  options.forces = pull_at_end(model, {20 * 2000, 0, 0});  // 32 %
  State state = rest_state(model);
  int limits = 0;
  test::simulate(model, options, 60, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.001);
    limits = report.limits_active;
  });
  CHECK(limits == model.num_hexes());
  CHECK(state.positions.col(0).maxCoeff() == Approx(1.05).epsilon(1e-3));
}

TEST_CASE("any forces change a free body's momentum by their sum and its angular momentum by their torque") {
  const Method method = GENERATE(direct, multigrid);
  const Model model = make_model({test::make_block({3, 2, 2}, {0, 1, 0}, 0.1)}, {});
  StepOptions options = options_with(method);
  options.solver.tolerance = 1e-8;
  options.forces.resize(model.num_nodes(), 3);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    options.forces.row(node) << std::sin(double(node)), std::cos(2.0 * double(node)), std::sin(3.0 * double(node) + 1);
  State state = rest_state(model);
  // what implicit Euler gains about the centre of mass: h r1 x f, of where nodes are at a step's end, and h m u1 x u0
  Vector3d gained_about = Vector3d::Zero();
  Points velocities_t0 = state.velocities;  // u0, as the centre has it
  const Vector3d sum = options.forces.colwise().sum().transpose();
  test::simulate(model, options, 5, state, [&](const StepReport&, const State& now) {
    const Eigen::RowVector3d centre = test::mean_of(model.node_mass, now.positions),
                             drift = test::mean_of(model.node_mass, now.velocities);
    for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
      const Vector3d r = now.positions.row(node) - centre, u = now.velocities.row(node) - drift,
                     u0 = velocities_t0.row(node), f = options.forces.row(node);
      gained_about += options.time_step * (r.cross(f) + model.node_mass[node] * u.cross(u0));
    }
    velocities_t0 = now.velocities.rowwise() - drift;
  });
  const Vector3d gained = 5 * options.time_step * sum;
  CHECK((test::momentum(model, state) - gained).norm() < 1e-6 * gained.norm());
  CHECK((test::angular_momentum(model, state) - gained_about).norm() < 1e-5 * gained_about.norm());
}

TEST_CASE("of two bodies that are solved apart each feels its own forces") {
  Body left = test::make_block({2, 2, 2}, {0, 1, 0}, 0.1), right = test::make_block({3, 2, 2}, {5, 1, 0}, 0.1);
  right.name = "right";
  const Model model = make_model({left, right}, {});
  StepOptions options = options_with(GENERATE(direct, multigrid));
  options.forces = Points::Zero(model.num_nodes(), 3);
  const Model::BodyRange& second = model.bodies[1];
  options.forces.middleRows(second.first_node, second.num_nodes) =
      2.0 * model.node_mass.segment(second.first_node, second.num_nodes) * Eigen::RowVector3d(0, 1, 0);
  const State state = test::simulate(model, options, 4);
  CHECK(state.velocities.topRows(second.first_node).isZero(0));
  const auto velocities = state.velocities.middleRows(second.first_node, second.num_nodes);
  CHECK((velocities.rowwise() - Eigen::RowVector3d(0, 0.08, 0)).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("fixed nodes bear their forces, and no rows are no forces") {
  const Model model = make_model({clamped_bar()}, {});
  StepOptions options = options_with(direct);
  const State still = test::simulate(model, options, 3);
  options.forces = Points::Zero(model.num_nodes(), 3);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (model.node_fixed[node]) options.forces.row(node) << 1e6, -1e6, 1e5;
  CHECK(test::simulate(model, options, 3).positions == still.positions);
}

TEST_CASE("forces that do not fit the model are refused") {
  const Model model = make_model({clamped_bar()}, {});
  StepOptions options = options_with(direct);
  Workspace workspace(model);
  State state = rest_state(model);
  const auto refused = [&] { return test::failure_of([&] { step(model, options, workspace, state); }); };
  options.forces = Points::Zero(7, 3);
  CHECK(refused().code == 65);
  CHECK(refused().value == "7");
  options.forces = Points::Constant(model.num_nodes(), 3, std::numeric_limits<double>::quiet_NaN());
  CHECK(refused().code == 65);
  CHECK(state.step == 0);
}
