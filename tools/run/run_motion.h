// What the states of a run take up together, which every picture of it depends on: the room that the camera frames, and the
// range of heat maps. motion.json keeps it from the end of the simulation on, so that pictures need not read all states.
#pragma once

#include <filesystem>

#include "tools/pictures/heat.h"
#include "tools/run/run_folder.h"
#include "tools/setup/camera_framing.h"

namespace umax {

struct RunMotion {
  Box box;               // around the surfaces [m]
  ViewFit fit;           // of the scene\'s pictures
  HeatRange heat;        // of render.heatmap
  double departure = 0;  // [m] of the drawn surface from that which physics knows, at most
};

/// As kept, where that is of the states that are there and of this heat map; otherwise read from them. Throws Error.
RunMotion motion_of_run(const Simulation& simulation, const std::filesystem::path& run);

/// Keeps it for later, unless it is kept already. Throws Error.
void freeze_motion(const Simulation& simulation, const RunFolder& folder);

}  // namespace umax
