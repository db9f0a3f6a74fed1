// The exact method: the paper's beam against independent numbers, limits that hold, soft limits, halved steps.
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

TEST_CASE("a step that cannot converge in its iterations is halved, reported, and ends on time") {
  Body beam = test::make_beam();
  test::limit_energy(beam, 0.01);
  const Model model = make_model({beam}, {});
  StepOptions options = exact_options();
  options.time_step = 0.05;
  options.solver.max_newton_iterations = 3;
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

TEST_CASE("a body crumpled at random recovers its shape and then keeps its limits", "[slow]") {
  Body cube = test::make_block({4, 4, 4}, Vector3d::Constant(-0.5), 0.25);
  cube.limit.kind = LimitKind::hard;
  cube.limit.unit = LimitUnit::stretch;
  cube.limit.value = 0.2;
  const Model model = make_model({cube}, {});
  StepOptions options;
  options.gravity.setZero();
  State state = rest_state(model);
  unsigned seed = 7;
  for (Eigen::Index i = 0; i < state.positions.size(); ++i) {
    seed = seed * 1664525u + 1013904223u;
    state.positions.data()[i] = double(seed >> 8) / double(1u << 24) - 0.5;
  }
  bool feasible = false;
  test::simulate(model, options, 120, state, [&](const StepReport& report, const State& now) {
    REQUIRE(now.positions.allFinite());
    if (feasible && report.status == StepStatus::converged) CHECK(report.max_energy_ratio <= 1.001);
    if (!feasible && !now.been_feasible) CHECK(report.status == StepStatus::infeasible);
    feasible = now.been_feasible;
  });
  CHECK(feasible);
  CHECK(energy_ratios(model, options.solver, state).maxCoeff() < 0.01);
}
