// What a body's limits mean: the same limit in all its units and as the strains that fill it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// One limit at one time.
struct LimitReport {
  EnergyPart part = EnergyPart::whole;
  LimitKind kind = LimitKind::hard;
  LimitMeasure measure = LimitMeasure::mean;
  double time = 0;                 // [s]
  double energy = 0, density = 0;  // [J per hex], [J/m^3]
  LimitEquivalents strains;        // [-]
};

/// Volume [m^3] of a hex of the cage; of hexes from a file: their mean.
double mean_hex_volume(const Lattice& lattice);

/// The uniaxial stretch [-] that a value of a body's limit, in its unit, means at a time [s].
double stretch_of_limit(const BodyDescription& body, EnergyPart part, double value, double time, double hex_volume);

/// All limits of a body that are not "none", each at time 0 and, where it or the stiffness is keyframed, at every key.
/// hex_volume: mean_hex_volume(); factors of single hexes are not counted in.
std::vector<LimitReport> limit_reports(const BodyDescription& body, double hex_volume);

/// "0.1 J per hex = 388.9 J/m^3 = 7.201 % stretch (by itself: 11.6 % shear, 7.89 % volume change)"
std::string limit_text(const LimitReport& report, const std::string& hex = "hex");

/// For scene.toml: beside each limit's key what it means, by full key ("body.beam.limit.energy").
std::map<std::string, std::string> limit_comments(const Simulation& simulation);

/// Warns of every keyframed limit that falls so fast that it throws the body: by more than half a stretch in a second.
void warn_of_sudden_limits(const Simulation& simulation, std::vector<std::string>& warnings);

}  // namespace umax
