// A picture of a state that is in no run's folder.
#pragma once

#include "tools/pictures/painter.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// The shot of a state. Where the scene does not say where the camera stands, it frames the bodies as they are at the
/// start and now.
RenderScene shot_of_state(const Simulation& simulation, const State& start, const State& state);

}  // namespace umax
