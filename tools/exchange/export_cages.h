// Cages for ParaView and VTK: what each hex of a body holds in each frame, and at which times the frames are.
#pragma once

#include "tools/exchange/exported_things.h"

namespace umax {

/// FOLDER/NAME/NNNN.vtu of each body: its hexes with `energy` [J], `energy_ratio` U/U_max, `multiplier` lambda/U_max,
/// `stress` [Pa] (xx, yy, zz, xy, yz, xz), `von_mises` [Pa] and `body` (its index); its nodes with `velocity`. Throws
/// Error (cannot_create, io_error).
void write_cages(const Simulation& simulation, const std::vector<ExportedThing>& bodies, const ExportOptions& options,
                 const std::filesystem::path& folder, int frame, const State& state);

/// FOLDER/cages.pvd: all frames of these bodies that are there, each at its time, a part for each body.
void write_cage_index(const ClipDescription& clip, const std::vector<ExportedThing>& bodies,
                      const std::filesystem::path& folder);
std::filesystem::path cage_index_file(const std::filesystem::path& folder);

}  // namespace umax
