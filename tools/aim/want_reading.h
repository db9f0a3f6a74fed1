// What a run shows of a want.
#pragma once

#include <filesystem>
#include <vector>

#include "tools/aim/want.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

struct Reading {
  double value = 0;  // as Want::value; infinity: a rest that does not come within the clip
  double scale = 1;  // by which what is left counts: the wanted value, of a tip how far it has to go
  int frame = 1;     // at which it is seen best
};

/// Where the states of a run come from: those of a folder, or a test's own.
using StateSource = std::function<State(int frame)>;

/// Reads the frames that the want needs. Throws Error (bad_data) for a bounce of what does not land.
Reading read_want(const Want& want, const Simulation& simulation, const StateSource& states);

/// The states of a run's folder. Both must outlive what is returned.
StateSource states_of_run(const Simulation& simulation, const std::filesystem::path& run);

/// What is left, as a share of the scale: (value - wanted) / scale, from -10 to 10.
double miss_of(const Want& want, const Reading& reading);

}  // namespace umax
