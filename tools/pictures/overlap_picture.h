// A picture of where bodies are inside each other, or themselves, at the start.
#pragma once

#include "tools/setup/simulation_setup.h"

namespace umax {

/// The bodies at time 0, pale; what is inside another body marked by depth, as if seen through it: the whole scene, and
/// the deepest place from nearby. The overlaps are named with their depths. threads: as in RasterizeOptions. Throws Error
/// (unavailable) when there is no rasteriser.
Image8 overlap_picture(const Simulation& simulation, int threads);

}  // namespace umax
