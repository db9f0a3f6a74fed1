// The number of threads must not show in the result.
#include <tbb/global_control.h>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

State impact(SolverMethod method, std::size_t threads) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
  Body body = test::make_sphere(6, {0, 1.05, 0}, 2000);
  body.velocity = {1, -4, 0};
  body.spin = {0, 0, 2};
  test::limit_energy(body, 20);
  const Model model = make_model({body}, {test::make_ground(0.5)});
  StepOptions options{.time_step = 0.01};
  options.solver.method = method;
  options.solver.tolerance = 1e-2;
  State state = rest_state(model);
  int most_limits = 0, most_contacts = 0;
  test::simulate(model, options, 15, state, [&](const StepReport& report, const State&) {
    most_limits = std::max(most_limits, report.limits_active);
    most_contacts = std::max(most_contacts, report.contacts);
  });
  CHECK(most_limits > 5);
  CHECK(most_contacts > 5);
  return state;
}

}  // namespace

TEST_CASE("an impact with limits and friction is bit-identical for 1 and 2 threads") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const State one = impact(method, 1), two = impact(method, 2);
  CHECK(one.positions == two.positions);
  CHECK(one.velocities == two.velocities);
  CHECK(one.limit_multipliers == two.limit_multipliers);
  REQUIRE(one.contacts.size() == two.contacts.size());
  for (std::size_t i = 0; i < one.contacts.size(); ++i) CHECK(one.contacts[i].impulse == two.contacts[i].impulse);
}
