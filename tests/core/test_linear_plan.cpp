// Which linear solver is chosen for what.
#include "core/problem/linear_plan.h"

#include <tbb/global_control.h>

#include <vector>

#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;

namespace {

using Plan = std::vector<LinearBackend>;
constexpr LinearBackend direct = LinearBackend::direct, multigrid = LinearBackend::multigrid;

LinearTraits lattice(double hexes) {
  return {.name = "lattice", .hexes = hexes, .is_regular = true};
}
LinearTraits irregular(double hexes) {
  return {.name = "irregular", .hexes = hexes, .is_regular = false};
}

}  // namespace

TEST_CASE("the linear solver is the one asked for, or the faster one that suits the scene") {
  const auto plan = [](const std::vector<LinearTraits>& bodies, LinearSolver asked) {
    return plan_linear_solvers(bodies, {.linear = asked}).bodies;
  };
  const LinearSolver automatic = LinearSolver::automatic;
  CHECK(plan({lattice(599)}, automatic) == Plan{direct});
  CHECK(plan({lattice(600)}, automatic) == Plan{multigrid});
  CHECK(plan({irregular(5000)}, automatic) == Plan{direct});
  CHECK(plan({lattice(5000)}, LinearSolver::direct) == Plan{direct});
  CHECK(plan({lattice(8)}, LinearSolver::multigrid) == Plan{multigrid});
  CHECK(plan({lattice(0)}, LinearSolver::multigrid) == Plan{multigrid});  // of unknown size
  CHECK(plan({}, LinearSolver::multigrid).empty());
}

TEST_CASE("bodies that touch are solved alike: on multigrids where one of them is large and none is irregular") {
  const auto plan = [](const std::vector<LinearTraits>& bodies) { return plan_linear_solvers(bodies, {}); };
  CHECK(plan({lattice(1999), lattice(1999)}).bodies == Plan{direct, direct});
  CHECK(plan({lattice(8), lattice(2000)}).bodies == Plan{multigrid, multigrid});
  CHECK(plan({lattice(9000), irregular(8)}).bodies == Plan{direct, direct});
  CHECK(plan({lattice(9000), irregular(8)}).against_multigrid->where == "body.irregular.cage");
  CHECK(plan({lattice(9000), lattice(8)}).is_multigrid());
  CHECK_FALSE(plan({}).is_multigrid());
}

TEST_CASE("multigrids know the exact method, the true energy and the centre's rotation only") {
  const auto refusal = [](SolverOptions solver) {
    solver.linear = LinearSolver::multigrid;
    const LinearPlan plan = plan_linear_solvers({lattice(5000)}, solver);
    CHECK(plan.is_multigrid() == !plan.against_multigrid);
    return test::failure_of([&] { require_solvable(plan, solver); }).where;
  };
  CHECK(refusal({}).empty());
  CHECK(refusal({.energy = EnergyMeasure::paper}) == "solver.energy, solver.jacobian");
  CHECK(refusal({.jacobian = LimitJacobian::warped}) == "solver.energy, solver.jacobian");
  CHECK(refusal({.rotation = RotationEstimate::kuhn}) == "solver.rotation");
  CHECK(refusal({.method = SolverMethod::paper}).empty());  // the key is of the exact method
  CHECK(plan_linear_solvers({lattice(5000)}, {.rotation = RotationEstimate::kuhn}).bodies == Plan{direct});
}

TEST_CASE("a model tells the same traits as its bodies") {
  Body small = test::make_block({2, 2, 2}, {0, 0, 0}, 0.1), large = test::make_block({13, 13, 12}, {5, 0, 0}, 0.1);
  small.name = "small";
  large.name = "large";
  CHECK(plan_linear_solvers(make_model({small, large}, {}), {}).bodies == Plan{multigrid, multigrid});
  CHECK(plan_linear_solvers(make_model({small}, {}), {}).bodies == Plan{direct});
  const Body middle = test::make_block({10, 10, 10}, {0, 5, 0}, 0.1);
  CHECK(plan_linear_solvers(make_model({middle}, {}), {}).bodies == Plan{multigrid});
  CHECK(plan_linear_solvers(make_model({middle, small}, {}), {}).bodies == Plan{direct, direct});
  const Body bent = test::turned(test::make_beam(), rotation_from_degrees({10, 0, 0}));
  CHECK(plan_linear_solvers(make_model({large, bent}, {}), {}).against_multigrid);
}

TEST_CASE("two bodies of 648 hexes are solved on multigrids in flight and by factors while they touch") {
  Body left = test::touchable_block("left", {9, 9, 8}, {0, 0, 0}, 0.05);
  Body right = test::touchable_block("right", {9, 9, 8}, {0.55, 0.1, 0.05}, 0.05);
  left.velocity = {1, 0, 0};
  right.velocity = {-1, 0, 0};
  for (Body* body : {&left, &right}) body->spin = {0, 0, 4};  // so that flight has something to solve, too
  const Model model = make_model({left, right}, {});
  StepOptions options = test::without_gravity();
  options.time_step = 5e-3;
  const auto step_from = [&](State state, LinearSolver linear, std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    options.solver.linear = linear;
    Workspace workspace(model);
    CHECK(step(model, options, workspace, state).status == StepStatus::converged);
    return state;
  };
  options.solver.linear = LinearSolver::automatic;
  State state = rest_state(model);
  std::vector<State> states{state};
  test::simulate(model, options, 36, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    states.push_back(now);
  });
  std::vector<LinearSolver> in_turn;
  for (std::size_t k = 0; k + 1 < states.size(); k += 5) {
    CAPTURE(k);
    const auto leads_on = [&](LinearSolver linear, std::size_t threads) {
      return step_from(states[k], linear, threads).positions == states[k + 1].positions;
    };
    CHECK(leads_on(LinearSolver::automatic, 1));  // from the state alone
    const bool by_factors = leads_on(LinearSolver::direct, 2), on_multigrids = leads_on(LinearSolver::multigrid, 2);
    CHECK(by_factors != on_multigrids);
    const LinearSolver linear = by_factors ? LinearSolver::direct : LinearSolver::multigrid;
    if (in_turn.empty() || in_turn.back() != linear) in_turn.push_back(linear);
  }
  CHECK(in_turn == std::vector{LinearSolver::multigrid, LinearSolver::direct, LinearSolver::multigrid});
  const double size = (model.node_mass.transpose() * states[0].velocities.rowwise().norm()).value();
  CHECK((test::momentum(model, states.back()) - test::momentum(model, states[0])).norm() <
        options.solver.tolerance * size);
}
