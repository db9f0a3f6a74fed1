// A picture of the factors on a body's stiffness or limit: from the front and from the back, with a bar.
#pragma once

#include "tools/setup/simulation_setup.h"

namespace umax {

/// factors: of all hexes of the model [-]. The bodies at time 0 without obstacles, under even light. title: of the bar.
/// threads: as in RasterizeOptions. Throws Error (unavailable) when there is no rasteriser.
Image8 map_picture(const Simulation& simulation, const VectorXd& factors, const std::string& title, int threads);

}  // namespace umax
