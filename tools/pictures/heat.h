// What heat maps show: a number of each hex, and the bar of colours that it is read from.
//
// energy       U/U_max [-] of the hex's limit that is nearest to being reached, 0 without limit; the bar ends at the
//              limit
// multiplier   lambda/U_max [-], 0 without limit. The limit's force is -(lambda/U_max) dU/dx: it makes the hex so many
//              times stiffer. Of several limits the one that does so most; of a peak, the sum of its 8 points
// stretch      sqrt(2 U / (Y V)) [%] of the true energy U: the uniaxial stretch that costs as much, limit or not
//
// U: elastic energy [J];  U_max: its limit [J];  lambda: the limit's multiplier [J]
// Y: Young's modulus [Pa];  V: volume [m^3]
#pragma once

#include <limits>
#include <optional>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// What a bar must span for all pictures of a clip to share it. In the map's unit.
struct HeatRange {
  double largest = 0;                                            // of all hexes
  double least_limit = std::numeric_limits<double>::infinity();  // of all hexes, as stretch [%]; infinity: no limit
  double largest_limit = 0;
};

/// What render.heatmap shows of each hex in this state: #E; empty for "none".
VectorXd heat_values(const Simulation& simulation, const State& state);

/// The same of another map.
VectorXd heat_values(const Simulation& simulation, const State& state, Heatmap map);

/// Widens the range by a state. A clip's range is that of all its states.
void extend(HeatRange& range, const Simulation& simulation, const State& state);

/// The bar for render.heatmap; none for "none". energy: 0 to the limit. multiplier: logarithmic, 0 to the largest,
/// rounded up. stretch: 0 to the limit where all hexes have the same one at all times and it bounds the true energy,
/// otherwise to the largest, rounded up (so it is with limits on parts or peaks, which this stretch does not measure).
/// render.heatmap_top ends the latter two where it says. What is within the solver's tolerance of a limit counts as
/// reached.
std::optional<Legend> heat_legend(const Simulation& simulation, const HeatRange& range);

}  // namespace umax
