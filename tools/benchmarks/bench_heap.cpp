// Figures of the built-in scene `heap`: what contact between twelve bodies costs beside the same bodies far apart, whether
// every step is solved, and how deep any surface lies in another by code that is not the contact's.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/bench_penetration.h"

namespace umax {
namespace {

constexpr double most_expensive = 2;   // times the mean step far apart
constexpr double most_halved = 0.01;   // of the steps
constexpr double distance_apart = 10;  // [m]
constexpr int states_between_measures = 10;

struct HeapRun {
  double seconds = 0;
  int steps = 0, not_converged = 0, halved = 0, iterations = 0;
  WorstPenetration worst;
};

HeapRun run(const Simulation& simulation, bool measures) {
  const std::vector<test::MeasuredBody> bodies =
      measures ? measured_bodies(simulation) : std::vector<test::MeasuredBody>{};
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  HeapRun heap;
  for (int frame = 1; frame < simulation.last_frame(); ++frame) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    heap.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++heap.steps;
    heap.not_converged += report.status != StepStatus::converged;
    heap.halved += report.retries > 0;
    heap.iterations += report.sqp_iterations;
    if (measures && frame % states_between_measures == 0) measure(simulation, bodies, state, heap.worst);
  }
  return heap;
}

// the scene's bodies, each 10 m from the next
std::vector<Override> far_apart(const Scene& scene) {
  std::vector<Override> overrides;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Vector3d& at = *scene.bodies[i].position;
    overrides.push_back(parse_override(fmt::format("body.{}.position=[{}, {}, {}]", scene.bodies[i].name,
                                                   at[0] + distance_apart * double(i), at[1], at[2])));
  }
  return overrides;
}

BenchRows heap_benchmark() {
  const Scene scene = load_scene("heap");
  const HeapRun apart = run(set_up(load_scene("heap", far_apart(scene))), false);
  const HeapRun heap = run(set_up(scene), true);
  BenchRows rows;
  const double step_ms = 1e3 * heap.seconds / heap.steps, apart_ms = 1e3 * apart.seconds / apart.steps;
  rows.push_back(at_most("heap: mean step over that of the same bodies far apart", step_ms / apart_ms, most_expensive,
                         "times", fmt::format("{:.0f} ms, {:.0f} ms", step_ms, apart_ms)));
  rows.push_back(at_most("heap: steps that did not converge", heap.not_converged, 0, "steps",
                         fmt::format("of {}, {} iterations", heap.steps, heap.iterations)));
  rows.push_back(at_most("heap: steps that were halved", double(heap.halved) / heap.steps, most_halved, "of all"));
  append_penetration("heap", heap.worst, rows);
  return rows;
}

}  // namespace

std::vector<Benchmark> heap_benchmarks() {
  return {{.name = "heap", .slow = true, .run = heap_benchmark}};
}

}  // namespace umax
