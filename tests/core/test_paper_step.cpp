// The paper's method on the paper's scenes. Expected tips: an independent prototype, agreed to by three other methods.
#include <map>

#include "core/step/paper_step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

StepOptions paper_options(EnergyMeasure energy, LimitJacobian jacobian) {
  StepOptions options{.time_step = 0.01};
  options.solver.method = SolverMethod::paper;
  options.solver.tolerance = 1e-2;
  options.solver.energy = energy;
  options.solver.jacobian = jacobian;
  return options;
}

struct Swing {
  double lowest_tip = 0;  // [m] of the free end's centre, against rest
  std::vector<int> iterations;
  double highest_ratio = 0;
  int total_iterations() const {
    int sum = 0;
    for (const int i : iterations) sum += i;
    return sum;
  }
};

Swing swing_beam(double limit, const StepOptions& options, int steps = 80) {
  Body beam = test::make_beam();
  if (limit > 0) test::limit_energy(beam, limit);
  const Model model = make_model({beam}, {});
  State state = rest_state(model);
  Swing swing;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& now) {
    const int tip = test::beam_tip();
    swing.lowest_tip = std::min(swing.lowest_tip, now.positions(tip, 1) - model.rest_positions(tip, 1));
    swing.iterations.push_back(report.sqp_iterations);
    swing.highest_ratio = std::max(swing.highest_ratio, report.max_energy_ratio);
    CHECK(report.status == StepStatus::converged);
    CHECK(report.factorisations == 1);
  });
  return swing;
}

void check_tips(EnergyMeasure energy, const std::map<double, double>& expected) {
  for (const auto& [limit, tip] : expected) {
    CAPTURE(limit);
    const Swing swing = swing_beam(limit, paper_options(energy, LimitJacobian::exact));
    CHECK(swing.lowest_tip == Approx(tip).margin(3e-3));
    CHECK(swing.highest_ratio <= 1 + 1e-2);
  }
}

// dropped from 1 m; lowest and later highest height of the centre
struct Bounce {
  double lowest = 1e9, highest_after = 0;
};

Bounce drop_sphere(double limit, EnergyMeasure energy) {
  Body sphere = test::make_sphere(3, {0, 2, 0});
  sphere.friction = 0.5;
  if (limit > 0) test::limit_energy(sphere, limit);
  const Model model = make_model({sphere}, {test::make_ground()});
  const StepOptions options = paper_options(energy, LimitJacobian::exact);
  State state = rest_state(model);
  Bounce bounce;
  test::simulate(model, options, 160, state, [&](const StepReport& report, const State& now) {
    const double height = test::mean_of(model.node_mass, now.positions).y();
    if (height < bounce.lowest) bounce.lowest = height, bounce.highest_after = height;
    bounce.highest_after = std::max(bounce.highest_after, height);
    CHECK(report.max_energy_ratio <= 1.01);
    CHECK(report.max_penetration <= 1e-3 * 2 / 3);
  });
  return bounce;
}

}  // namespace

TEST_CASE("the beam's first swing under the paper's energy limit") {
  check_tips(EnergyMeasure::paper, {{1, -0.917}, {0.1, -0.603}});
}

TEST_CASE("the beam's first swing under the true energy limit") {
  check_tips(EnergyMeasure::true_energy, {{1, -0.949}, {0.1, -0.715}});
}

TEST_CASE("the beam's first swing under every limit of the paper", "[slow]") {
  check_tips(EnergyMeasure::paper, {{0.5, -0.855}, {0.05, -0.463}, {0.01, -0.221}});
  check_tips(EnergyMeasure::true_energy, {{0.5, -0.907}, {0.05, -0.586}, {0.01, -0.296}});
}

TEST_CASE("without a limit the beam swings further and takes no iteration") {
  const Swing swing = swing_beam(0, paper_options(EnergyMeasure::true_energy, LimitJacobian::exact));
  CHECK(swing.lowest_tip == Approx(-0.960).margin(3e-3));
  CHECK(swing.total_iterations() == 0);
}

TEST_CASE("the paper's gain: the warped force as Jacobian costs more iterations under the paper's energy") {
  const double limit = GENERATE(0.5, 0.1);
  const int fixed =
      swing_beam(limit, paper_options(EnergyMeasure::paper, LimitJacobian::fixed_rotation)).total_iterations();
  const int warped = swing_beam(limit, paper_options(EnergyMeasure::paper, LimitJacobian::warped)).total_iterations();
  CAPTURE(limit, fixed, warped);
  CHECK(double(warped) / fixed > 1.2);
}

TEST_CASE("under the true energy the warped force is the Jacobian with the rotation held: the same iterations") {
  const Swing fixed = swing_beam(0.1, paper_options(EnergyMeasure::true_energy, LimitJacobian::fixed_rotation));
  const Swing warped = swing_beam(0.1, paper_options(EnergyMeasure::true_energy, LimitJacobian::warped));
  CHECK(fixed.iterations == warped.iterations);
  CHECK(fixed.lowest_tip == Approx(warped.lowest_tip).margin(1e-9));
}

TEST_CASE("the paper's sphere does not rebound under its limit, and does without") {
  const Bounce free = drop_sphere(0, EnergyMeasure::paper);
  CHECK(free.lowest < 0.65);
  CHECK(free.highest_after > 1.15);
  const Bounce limited = drop_sphere(500, EnergyMeasure::paper);
  CHECK(limited.lowest == Approx(0.816).margin(0.02));
  CHECK(limited.highest_after < 1.05);
}
