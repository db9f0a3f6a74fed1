// The exact step on multigrids: whole steps against the direct solver.
#include <tbb/global_control.h>

#include <algorithm>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/hex_samples.h"
#include "tests/support/linearised_step.h"

using namespace umax;

namespace {

struct Run {
  State state;
  int limits = 0, contacts = 0, not_converged = 0, sqp = 0, linear = 0;
  double ratio = 0, kkt = 0, depth = 0;
};

Run run(const Model& model, LinearSolver linear, int steps, double time_step = 0.01) {
  StepOptions options{.time_step = time_step};
  options.solver.linear = linear;
  Run run{rest_state(model)};
  test::simulate(model, options, steps, run.state, [&](const StepReport& report, const State&) {
    run.limits = std::max(run.limits, report.limits_active);
    run.contacts = std::max(run.contacts, report.contacts);
    run.not_converged += report.status != StepStatus::converged;
    run.sqp += report.sqp_iterations;
    run.linear += report.linear_iterations;
    run.ratio = std::max(run.ratio, report.max_energy_ratio);
    run.kkt = std::max(run.kkt, report.kkt_residual);
    run.depth = std::max(run.depth, report.max_penetration);
  });
  return run;
}

Model thrown_sphere() {
  Body body = test::make_sphere(6, {0, 1.05, 0}, 2000);
  body.velocity = {1, -4, 0};
  body.spin = {0, 0, 2};
  test::limit_energy(body, 20);
  return make_model({body}, {test::make_ground(0.5)});
}

}  // namespace

TEST_CASE("both linear solvers make the same steps of an impact with limits and friction") {
  const Model model = thrown_sphere();
  const Run direct = run(model, LinearSolver::direct, 15), multigrid = run(model, LinearSolver::multigrid, 15);
  REQUIRE(direct.limits > 5);
  REQUIRE(direct.contacts > 5);
  CHECK(multigrid.not_converged == 0);
  CHECK(multigrid.ratio <= 1.001);
  CHECK(multigrid.kkt <= 1e-3);
  CHECK(multigrid.depth <= 1e-3 * model.bodies.front().cell_size);
  CHECK((multigrid.state.positions - direct.state.positions).cwiseAbs().maxCoeff() <=
        2e-3 * model.bodies.front().cell_size);
  CHECK(multigrid.sqp <= 2 * direct.sqp);
  CHECK(multigrid.linear <= 600);  // 302 with AVX-512
}

TEST_CASE("a beam that is pulled taut and swings is no matter of many iterations on multigrids") {
  Body beam = test::make_beam();  // along x, held at its start
  beam.velocity = {30, 10, 0};
  beam.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.05};
  const Model model = make_model({beam}, {});
  const Run multigrid = run(model, LinearSolver::multigrid, 12, 0.02);
  REQUIRE(multigrid.limits > 40);
  CHECK(multigrid.not_converged == 0);
  CHECK(multigrid.sqp <= 160);  // 105; 304 and a step that fails where steps to and fro are not corrected
}

namespace {

// a step, after one of 1/60 s, of a block of n^3 hexes that is thrown across where it is clamped, and limited tightly
StepReport step_of_tight_block(int n, StepOptions options) {
  Body block = test::make_block(Vector3i::Constant(n), {0, 0, 0}, 1.0 / n);
  block.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.02};
  for (Eigen::Index node = 0; node < block.lattice.rest_positions.rows(); ++node)
    if (block.lattice.rest_positions(node, 0) == 0) block.fixed_nodes.push_back(int(node));
  const Model model = make_model({block}, {});
  State state = rest_state(model);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (!model.node_fixed[node]) state.velocities(node, 1) = -3 * model.rest_positions(node, 0);
  options.solver.linear = LinearSolver::multigrid;
  Workspace workspace(model);
  StepOptions before = options;
  before.time_step = 1.0 / 60;
  step(model, before, workspace, state);
  return step(model, options, workspace, state);
}

}  // namespace

TEST_CASE("a step whose hexes are nearly all at their limits is no matter of many iterations on multigrids") {
  const StepReport report = step_of_tight_block(24, {.time_step = 1.0 / 60});
  REQUIRE(report.limits_active > 10000);  // the complement is not factored
  CHECK(report.status == StepStatus::converged);
  CHECK(report.retries == 0);
  CHECK(report.max_energy_ratio <= 1.001);
  CHECK(report.linear_iterations <= 38);  // 32; 46 with a penalty of 1e4 U_max
}

TEST_CASE("a block that flies where a clamp holds a side of it is no matter of many iterations") {
  Body block = test::make_block(Vector3i::Constant(16), {0, 0, 0}, 1.0 / 16);
  block.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
  block.velocity = {0, -30, 0};  // eight cells in the step
  for (Eigen::Index node = 0; node < block.lattice.rest_positions.rows(); ++node)
    if (block.lattice.rest_positions(node, 0) == 0) block.fixed_nodes.push_back(int(node));
  for (const LinearSolver linear : {LinearSolver::multigrid, LinearSolver::direct}) {
    const Run flown = run(make_model({block}, {}), linear, 1, 1.0 / 60);
    REQUIRE(flown.limits > 100);
    CHECK(flown.not_converged == 0);
    CHECK(flown.ratio <= 1.001);
    CHECK(flown.sqp <= 14);  // 10; 38 where the guess is the whole way
  }
}

TEST_CASE("a step on multigrids that is nearly solved is not given up for two halves") {
  StepOptions options{.time_step = 1.0 / 960};
  options.solver.tolerance = 2e-3;
  options.solver.max_newton_iterations = 2;
  std::vector<double> residuals;
  options.on_iteration = [&](const IterationReport& at) { residuals.push_back(at.kkt_residual); };
  const StepReport report = step_of_tight_block(6, options);
  CHECK(report.status == StepStatus::converged);
  CHECK(report.retries == 0);
  const int usual = 2 * options.solver.max_newton_iterations;
  REQUIRE(report.sqp_iterations > usual);
  const double at_limit = residuals[residuals.size() - 1 - std::size_t(report.sqp_iterations - usual)];
  CHECK(at_limit > options.solver.tolerance);
  CHECK(at_limit <= 3 * options.solver.tolerance);
}

namespace {

// The thrown sphere as it touches the ground, in one linearisation.
struct Impact : test::LinearisedStep {
  explicit Impact(const Model& sphere = thrown_sphere())
      : LinearisedStep(sphere, run(sphere, LinearSolver::direct, 8).state) {
    add_contacts(problem.contact, iterate.apart, iterate.positions, 0.5, iterate.contacts);
    REQUIRE(iterate.contacts.size() >= 5);
  }
};

}  // namespace

TEST_CASE("limits hold in a linearised step on multigrids, however often its contacts were corrected") {
  Impact impact;
  impact.iterate.residuals = {GENERATE(1e-2, 1e-3)};
  CAPTURE(impact.iterate.residuals.back());
  const NewtonStep newton = impact.minimise();
  const Model& model = impact.model;
  const Evaluation& evaluation = impact.iterate.evaluation;
  double violation = 0, left = 0;
  int held = 0;
  for (Eigen::Index l = 0; l < impact.problem.materials.limits.size(); ++l) {
    if (!(impact.at.limits[l].rank_one > 0)) continue;
    ++held;
    const Vector24d gradient = evaluation.limit_gradient(model, l);
    double change = 0;
    for (int n = 0; n < 8; ++n)
      change += gradient.segment<3>(3 * n).dot(newton.step.segment<3>(3 * model.hexes(model.limits[l].hex, n)));
    violation = std::max(violation, std::abs(evaluation.energy[l] - impact.problem.materials.limits[l]));
    left = std::max(left, std::abs(change - newton.limit_change[l]));
  }
  REQUIRE(held > 5);
  CHECK(left <= 0.01 * violation);  // 0.002 on the machine that it was written on
}

TEST_CASE("with contacts linear systems are solved the more exactly the faster the residual falls") {
  const auto iterations = [](double kkt_fall) {
    Impact impact;
    impact.iterate.residuals = {0.3 / kkt_fall, 0.3};  // its contacts settle at once
    impact.minimise();
    return impact.report.linear_iterations;
  };
  const int slow = iterations(1), fast = iterations(0.05);
  CAPTURE(slow, fast);
  CHECK(slow <= 0.8 * fast);
}

TEST_CASE("contacts that all miss a little of their forces do not let a body sink in on multigrids") {
  constexpr double cell = 0.05, sunk = 4e-5;  // [m]
  const Model model = make_model({test::make_block({8, 3, 8}, {0, 0, 0}, cell)}, {test::make_ground(0.5)});
  State state = run(model, LinearSolver::direct, 10).state;  // rests, and is then pushed
  state.velocities.col(1).array() -= sunk / 0.01;
  test::LinearisedStep step(model, state);
  Iterate& iterate = step.iterate;
  update_contacts(step.problem.contact, iterate.apart, iterate.positions, iterate.contacts);
  const std::vector<Contact> before = iterate.contacts;
  REQUIRE(before.size() > 50);
  REQUIRE(deepest(before) > 0.9 * sunk);
  iterate.residuals = {0.3};  // forces need be right to a tenth of the largest
  const NewtonStep newton = step.minimise();
  double depth = 0;
  for (const Contact& contact : before)
    depth = std::max(depth, -contact.gap - contact.normal.dot(contact_motion(model, contact, newton.step)));
  CHECK(depth <= 0.6 * sunk);
}

TEST_CASE("where forces are in balance and constraints hold a step on multigrids moves nothing") {
  const auto step_at = [](double kkt_residual) {
    Body block = test::make_block({8, 3, 8}, {0, 1, 0}, 0.05);
    block.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
    const Model model = make_model({block}, {test::make_ground(0.5)});
    State state = rest_state(model);
    state.velocities(0, 0) = 1e-3;  // is not where the predictor leaves it
    test::LinearisedStep step(model, state);
    step.iterate.residuals = {kkt_residual};
    REQUIRE(step.slope().norm() > 0);
    return step.minimise().step;
  };
  CHECK(step_at(1e-3).isZero(0));
  CHECK_FALSE(step_at(1.1e-3).isZero(0));
}

TEST_CASE("where no matrix is assembled hexes are evaluated alike, and nothing more is kept of them") {
  Impact impact;
  const Evaluation& with = impact.iterate.evaluation;
  REQUIRE(with.hexes.size() == std::size_t(impact.model.num_hexes()));
  impact.problem.plan.bodies = {LinearBackend::multigrid};
  Evaluation without;
  evaluate(impact.problem, impact.iterate.positions, without);
  CHECK(without.hexes.empty());
  CHECK(without.elastic == with.elastic);
  CHECK(without.energy == with.energy);
  CHECK(without.internal == with.internal);
}

TEST_CASE("a step on multigrids is bit-identical for 1 and 2 threads") {
  const Model model = thrown_sphere();
  const auto with = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return run(model, LinearSolver::multigrid, 12).state;
  };
  const State one = with(1), two = with(2);
  CHECK(one.positions == two.positions);
  CHECK(one.velocities == two.velocities);
  CHECK(one.limit_multipliers == two.limit_multipliers);
  REQUIRE(one.contacts.size() == two.contacts.size());
  for (std::size_t i = 0; i < one.contacts.size(); ++i) CHECK(one.contacts[i].impulse == two.contacts[i].impulse);
}

TEST_CASE("several bodies, fixed nodes, soft limits and limits on parts step alike with both linear solvers") {
  Body beam = test::make_beam();
  beam.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.05};
  Body soft = test::make_block({4, 3, 3}, {0.3, 0.5, 0}, 0.05);
  soft.name = "soft";
  soft.velocity = {0, -2, 0.5};
  soft.limit = {.kind = LimitKind::soft, .unit = LimitUnit::stretch, .value = 0.1};
  Body parts = test::make_block({3, 4, 3}, {0.7, 0.5, 0}, 0.05);
  parts.name = "parts";
  parts.velocity = {0, -3, 0};
  parts.part_limits.volumetric = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.05};
  parts.part_limits.deviatoric = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.08};
  Obstacle ground = test::make_ground(0.3);
  ground.position = Track<Vector3d>(Vector3d(0, 0.4, 0));
  const Model model = make_model({beam, soft, parts}, {ground});
  const Run direct = run(model, LinearSolver::direct, 12), multigrid = run(model, LinearSolver::multigrid, 12);
  REQUIRE(direct.limits > 0);
  REQUIRE(direct.contacts > 0);
  CHECK(direct.not_converged == 0);
  CHECK(multigrid.not_converged == 0);
  CHECK(multigrid.ratio <= 1.001);
  CHECK((multigrid.state.positions - direct.state.positions).cwiseAbs().maxCoeff() <= 2e-3 * 0.05);
}

TEST_CASE("a free turning body on multigrids gains the momentum of gravity and no other") {
  Body body = test::make_block({9, 6, 6}, {0, 5, 0}, 0.1);
  body.velocity = {1, 2, 3};
  body.spin = {1, -2, 0.5};
  const Model model = make_model({body}, {});
  const State start = rest_state(model);
  const int steps = 20;
  const Run run_ = run(model, LinearSolver::multigrid, steps, 1.0 / 600);
  const Vector3d gained = test::total_mass(model) * steps / 600.0 * Vector3d(0, -9.81, 0);
  const Vector3d before = test::momentum(model, start);
  CHECK((test::momentum(model, run_.state) - before - gained).norm() <= 1e-4 * before.norm());
}

TEST_CASE("what multigrids cannot solve is refused by name, and left to the direct solver where it is open") {
  const Body body = test::turned(test::make_beam(), rotation_from_degrees({10, 0, 0}));
  const Model model = make_model({body}, {});
  StepOptions options;
  CHECK(plan_linear_solvers(model, options.solver).against_multigrid);
  State state = rest_state(model);
  Workspace workspace(model);
  CHECK(step(model, options, workspace, state).status == StepStatus::converged);
  options.solver.linear = LinearSolver::multigrid;
  const test::Failure failure = test::failure_of([&] { step(model, options, workspace, state); });
  CHECK(test::contains(failure.message, "no regular lattice"));
  options.solver.method = SolverMethod::paper;  // has linear systems of its own
  CHECK_NOTHROW(require_solvable(plan_linear_solvers(model, options.solver), options.solver));
}

TEST_CASE("on multigrids too a crumpled start finds its shape, by the safety net") {
  Body body = test::make_block({3, 3, 3}, {0, 1, 0}, 0.1);
  body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
  const Model model = make_model({body}, {});
  StepOptions options;
  options.solver.linear = LinearSolver::multigrid;
  State state = rest_state(model);
  test::Random random(11);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    state.positions.row(node) = Eigen::RowVector3d(0.15, 1.15, 0.15) + random.vector(0.15).transpose();
  StepReport last;
  test::simulate(model, options, 60, state, [&](const StepReport& report, const State&) { last = report; });
  CHECK(last.status == StepStatus::converged);
  CHECK(last.max_energy_ratio <= 1.001);
  CHECK(state.been_feasible);
}
