// The built-in scenes that show what leads bodies: a gripper's friction, and pins.
#include "core/model/pins.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

/// Runs a built-in scene; all steps converge and none is halved. look(state, report) after each.
template <class Look>
void run_scene(const char* name, const Look& look) {
  const Simulation simulation = set_up(load_scene(name));
  CHECK(simulation.warnings.empty());
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  for (int frame = 2; frame <= simulation.last_frame(); ++frame) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    CAPTURE(frame);
    CHECK(report.status == StepStatus::converged);
    CHECK(report.retries == 0);
    CHECK(report.substeps == 1);
    look(simulation, state, report);
  }
}

}  // namespace

TEST_CASE("the gripper of the scene grab lifts its ball by friction alone, and sets it down") {
  double highest = 0, last = 0;
  run_scene("grab", [&](const Simulation& simulation, const State& state, const StepReport&) {
    last = probe_positions(simulation, state.positions)[0].y();
    highest = std::max(highest, last);
  });
  CHECK(highest > 0.75);  // from 0.25
  CHECK(last < 0.27);
}

TEST_CASE("the puppet walks where its pins are led, and its flesh swings as far as its limit lets it", "[slow]") {
  double largest = 0, farthest = 0;
  run_scene("puppet", [&](const Simulation& simulation, const State& state, const StepReport& report) {
    largest = std::max(largest, report.max_energy_ratio);
    const double belly = probe_positions(simulation, state.positions)[0].z() - 0.3;
    const Pin& neck = simulation.model.bodies[0].pins->pins()[1];
    farthest = std::max(farthest, std::abs(belly - neck.motion.position.at(state.time).z()));
  });
  CHECK(largest > 0.99);
  CHECK(largest <= 1.001);
  CHECK(farthest > 0.015);
}
