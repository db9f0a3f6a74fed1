// What pictures that explain a scene have in common: bodies at time 0 under even light, views side by side with a bar.
#pragma once

#include <vector>

#include "tools/pictures/shot.h"

namespace umax {

inline constexpr int view_width = 640, view_height = 720;  // [px] of each view

/// The shot of bodies alone, lit for the camera; size: [m] of what is seen.
void light_evenly(const Simulation& simulation, double size, RenderScene& shot);

/// The views side by side, with the bar at their right.
Image8 side_by_side(const std::vector<Image8>& views, const Legend& legend);

}  // namespace umax
