// One step of a simulation after the other, with what its scene changes from step to step: keys, gravity, pulls.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

struct Stepping {
  const Simulation* simulation = nullptr;
  std::unique_ptr<Model> own;            // a copy of its model that keys change; null: nothing to change, or in place
  Model* keyed = nullptr;                // what keys change; null: nothing
  StepOptions options;                   // of the next step
  std::unique_ptr<Workspace> workspace;  // null: to be made

  const Model& model() const { return keyed ? *keyed : simulation->model; }
};

/// The simulation must outlive it, and is not changed.
Stepping begin_stepping(const Simulation& simulation);

/// As begin_stepping(), but keys change the simulation's own model. What a step reads of the model may be changed between
/// steps if the workspace is given up (forget_model()).
Stepping begin_stepping_in_place(Simulation& simulation);

/// To be called when materials or limits of the model have been changed in place: gives up what holds copies of them.
void forget_model(Stepping& stepping);

/// Advances the state by a time step that has these pulls. The bits are decided by the scene, the state and the pulls.
StepReport advance(Stepping& stepping, const std::vector<Pull>& pulls, State& state);

/// The steps from rest to the first frame that are not shown (clip.preroll), and how many of them did not converge.
struct Preroll {
  long long steps = 0, not_converged = 0;
};
/// Leads a state at rest to the first frame. before_step: called before each step; what it throws ends the work.
Preroll preroll(Stepping& stepping, const std::function<void()>& before_step, State& state);

/// The pulls that the simulation's scene has recorded for the step that begins at the state.
const std::vector<Pull>& recorded_pulls(const Simulation& simulation, const State& state);

}  // namespace umax
