// The factors that a body's maps put on its stiffness and its limit, hex by hex.
#pragma once

#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// Multiplies the body's factors by those of its maps, sets the directions of its fibre where a map has them, and fills
/// setup.young_map and setup.limit_map. Appends what the
/// user should know to `warnings`: hexes that a map does not reach, values that were clamped, a map without a limit.
/// Throws Error naming body, key and file.
void apply_maps(const BodyDescription& description, BodySetup& setup, Body& body, std::vector<std::string>& warnings);

/// One line: where the map is from, its factors, what is outside, what was clamped.
std::string describe(const BodyMap& map);

}  // namespace umax
