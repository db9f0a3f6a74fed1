// Which linear solver is chosen for what.
#include "core/problem/linear_plan.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

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
