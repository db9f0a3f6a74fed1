// How the spheres of figures 4 and 5 are drawn: chequered, so that one sees what happens to the surface.
#pragma once

#include <string>
#include <vector>

#include "tools/reproduce/workbench.h"

namespace umax {

/// Settings of the scenes "sphere" and "collapse": from a little above, on a ground without a horizon.
std::vector<std::string> ball_view();

/// A run's frame with fields of meridians and parallels on the ball, as it was at rest.
Tile chequered_tile(const Run& run, int frame, const std::string& label);

}  // namespace umax
