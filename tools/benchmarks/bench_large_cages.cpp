// Whole steps of large cages on multigrids: what limits cost, how the time grows with the hexes.
#include <fmt/format.h>

#include <chrono>

#include "core/step/step.h"
#include "tools/benchmarks/bench.h"

namespace umax {
namespace {

// A block of n^3 hexes, 1 m wide, clamped at x = 0, thrown across itself with y velocities -speed(x). stretch: its
// limit, 0 for none.
struct ThrownBlock {
  Model model;
  State state;

  template <class Speed>
  ThrownBlock(int n, double stretch, const Speed& speed) {
    Body body;
    body.name = "block";
    body.lattice = make_box_lattice(Vector3i::Constant(n), Vector3d::Zero(), Vector3d::Constant(1.0 / n));
    body.material.mass = MassModel::lattice;
    if (stretch > 0) body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = stretch};
    body.surface.weights.resize(0, 8);
    for (Eigen::Index node = 0; node < body.lattice.rest_positions.rows(); ++node)
      if (body.lattice.rest_positions(node, 0) == 0) body.fixed_nodes.push_back(int(node));
    model = make_model({body}, {});
    state = rest_state(model);
    for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
      if (!model.node_fixed[node]) state.velocities(node, 1) = -speed(model.rest_positions(node, 0));
  }
};

struct TimedStep {
  double seconds = 0, limited_share = 0;  // of the hexes
  StepReport report;
};

// the steps from the second one on; the first one makes the workspace
std::vector<TimedStep> steps_of(ThrownBlock block, int count) {
  StepOptions options;
  options.time_step = 1.0 / 60;
  options.solver.linear = LinearSolver::multigrid;
  Workspace workspace(block.model);
  step(block.model, options, workspace, block.state);
  std::vector<TimedStep> timed(static_cast<std::size_t>(count));
  for (TimedStep& one : timed) {
    const auto start = std::chrono::steady_clock::now();
    one.report = step(block.model, options, workspace, block.state);
    one.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    one.limited_share = double(one.report.limits_active) / double(block.model.num_hexes());
  }
  return timed;
}

std::string remark(const TimedStep& timed) {
  return fmt::format("{:.3g} s, {:.0f} % at their limits, {} + {} its", timed.seconds, 100 * timed.limited_share,
                     timed.report.sqp_iterations, timed.report.linear_iterations);
}

BenchRows growth() {
  const auto speed = [](double x) { return 24 * x * x; };
  const TimedStep small = steps_of({46, 0.2, speed}, 1).front(), large = steps_of({100, 0.2, speed}, 1).front();
  const double per_hex = large.seconds / 1e6 / (small.seconds / (46. * 46 * 46));
  return {{"a step of 97 k hexes", remark(small), "", true},
          {"a step of 1 M hexes", remark(large), "", true},
          at_most("time per hex, 1 M over 97 k", per_hex, 2.5, "x", "aim 1.5"),
          at_most("their worst max U/U_max", std::max(small.report.max_energy_ratio, large.report.max_energy_ratio),
                  1.001, "")};
}

// The step in which the limits are reached, and those that follow.
BenchRows cost_of_limits() {
  constexpr int count = 8;
  const auto speed = [](double x) { return 3 * x; };
  const std::vector<TimedStep> with = steps_of({46, 0.02, speed}, count), without = steps_of({46, 0, speed}, count);
  double seconds = 0, seconds_without = 0;
  for (int i = 1; i < count; ++i) {
    seconds += with[std::size_t(i)].seconds / (count - 1);
    seconds_without += without[std::size_t(i)].seconds / (count - 1);
  }
  return {{"a step of 97 k hexes without limits", remark(without.front()), "", true},
          at_most("97 k hexes: cost of limits", with.front().seconds / without.front().seconds, 5, "x",
                  remark(with.front())),
          {"the seven steps after it",
           fmt::format("{:.2g} x: {:.3g} s, {:.3g} s without; the last: {}", seconds / seconds_without, seconds,
                       seconds_without, remark(with.back())),
           "", true}};
}

}  // namespace

std::vector<Benchmark> large_cage_benchmarks() {
  return {{"limits-97k", false, false, cost_of_limits}, {"growth", true, false, growth}};
}

}  // namespace umax
