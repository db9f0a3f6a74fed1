// The paper's armadillo: 365 hexes, 43,243 vertices, dropped on the ground.
#include "tests/support/armadillo.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

TEST_CASE("the armadillo lands within its limits and above the ground at every step", "[models]") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const double limit = GENERATE(100.0, 20.0);
  CAPTURE(int(method), limit);
  Body body = test::make_armadillo(0.1);
  body.velocity = {0, -4.2, 0};  // as from 1 m
  test::limit_energy(body, limit);
  const Model model = make_model({body}, {test::make_ground(0.5)});
  StepOptions options{.time_step = 1.0 / 60};
  options.solver.method = method;
  options.solver.tolerance = 1e-2;
  State state = rest_state(model);
  int most_contacts = 0;
  test::simulate(model, options, 45, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.01);
    CHECK(report.max_penetration <= 1e-3 * model.bodies[0].cell_size);
    most_contacts = std::max(most_contacts, report.contacts);
  });
  CHECK(most_contacts >= 3);
  CHECK(most_contacts <= 60);
}
