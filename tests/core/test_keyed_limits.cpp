// Limits and stiffness that change over time, on bodies that rest on their limits.
#include <algorithm>
#include <cmath>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr double tightened_from = 2, tightened_until = 3;  // [s]

Track<double> tightened(double from, double to) {
  Track<double> track(from);
  track.times = {tightened_from, tightened_until};
  track.values = {from, to};
  return track;
}

struct Motion {
  double largest_move = 0;  // [m] of a node in a step
  double path = 0;          // [m] sum of the largest moves
  double kinetic = 0;       // [J] most
  int steps = 0;

  double mean_move() const { return path / steps; }
};

struct Tightening {
  Motion resting, tightening, after;
  double last_kinetic = 0, highest_ratio = 0;
};

Tightening run(const Model& model, double seconds) {
  const StepOptions options{.time_step = 0.02};
  State state = rest_state(model);
  Points before = state.positions;
  Tightening result;
  test::simulate(model, options, int(std::lround(seconds / options.time_step)), state,
                 [&](const StepReport& report, const State& now) {
                   CHECK(report.status == StepStatus::converged);
                   CHECK(report.retries == 0);
                   result.highest_ratio = std::max(result.highest_ratio, report.max_energy_ratio);
                   const double move = (now.positions - before).rowwise().norm().maxCoeff();
                   before = now.positions;
                   result.last_kinetic = report.kinetic_energy;
                   if (now.time < tightened_from - 0.3) return;
                   Motion& motion = now.time < tightened_from + 1e-9    ? result.resting
                                    : now.time < tightened_until + 1e-9 ? result.tightening
                                                                        : result.after;
                   motion.largest_move = std::max(motion.largest_move, move);
                   motion.path += move;
                   motion.kinetic = std::max(motion.kinetic, report.kinetic_energy);
                   ++motion.steps;
                 });
  return result;
}

// no step stands out, and what moves during the keys comes to rest after them
void check_no_jump(const Tightening& result, double energy_scale) {
  CHECK(result.highest_ratio <= 1.001);
  CHECK(result.tightening.path > 0.05);
  CHECK(result.tightening.largest_move < 4 * result.tightening.mean_move());
  CHECK(result.after.largest_move <= 1.5 * result.tightening.largest_move);
  CHECK(result.tightening.kinetic < energy_scale);
  CHECK(result.after.kinetic <= 1.5 * result.tightening.kinetic);
  CHECK(result.last_kinetic < 0.01 * result.tightening.kinetic);
}

}  // namespace

TEST_CASE("a clamped beam follows a limit that tightens from 20 % to 5 % in a second without a jump") {
  Body beam = test::make_beam();
  beam.material.damping_mass = 4;
  beam.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = tightened(0.2, 0.05)};
  const auto interpolation = GENERATE(Interpolation::linear, Interpolation::smooth);
  beam.limit.value.interpolation = interpolation;
  // its tip rises by 0.3 m; 3.5 J are 7.2 kg at 1 m/s
  check_no_jump(run(make_model({beam}, {}), 5), 3.5);
}

TEST_CASE("a ball on the ground follows a limit that tightens from 20 % to 5 % in a second without a jump") {
  Body sphere = test::make_sphere(3, {0, 1, 0});
  sphere.material.young = 30e3;
  sphere.material.damping_mass = 4;
  sphere.friction = 0.5;
  sphere.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = tightened(0.2, 0.05)};
  check_no_jump(run(make_model({sphere}, {test::make_ground(0.5)}), 6), 500);  // 4000 kg at 0.5 m/s
}

TEST_CASE("with a keyframed stiffness a limit given as stretch follows: what hangs on it keeps its stretch") {
  Body block = test::make_block({1, 6, 1}, {0, 0, 0}, 0.1);
  block.material.damping_mass = 6;
  block.material.young = tightened(10e3, 14e3);
  block.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.03};
  for (int node = 0; node < int(block.lattice.num_nodes()); ++node)
    if (block.lattice.rest_positions(node, 1) > 0.6 - 1e-9) block.fixed_nodes.push_back(node);
  const Model model = make_model({block}, {});
  const double volume = model.shapes[0].volume;
  CHECK(energy_limit_at(model, 0, 2) == Approx(0.5 * 10e3 * 0.03 * 0.03 * volume));
  CHECK(energy_limit_at(model, 0, 3) == Approx(0.5 * 14e3 * 0.03 * 0.03 * volume));
  const StepOptions options{.time_step = 0.02};
  State state = rest_state(model);
  double at_start = 0, lowest_active = 6;
  test::simulate(model, options, 200, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.001);
    const double length = now.positions.col(1).maxCoeff() - now.positions.col(1).minCoeff();
    if (now.time < tightened_from - 0.1) return;
    if (at_start == 0) at_start = length;
    lowest_active = std::min(lowest_active, double(report.limits_active));
    CHECK(length == Approx(at_start).margin(1e-3));
  });
  CHECK(at_start > 0.6 * 1.02);
  CHECK(lowest_active >= 4);
}
