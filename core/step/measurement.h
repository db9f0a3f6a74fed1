// What a report tells of a state itself, however it was reached: limits, depths, energies.
#pragma once

#include "core/step/workspace.h"

namespace umax {

/// Of the state that a step has ended at. data: of that step; what its searches remember makes the measurement cheap.
void measure_into(const Model& model, const StepOptions& options, const State& state, Workspace::Data& data,
                  StepReport& report);

}  // namespace umax
