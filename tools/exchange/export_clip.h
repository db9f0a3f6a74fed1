// From the states of a run to files of other programs: caches and sequences of meshes, frame by frame.
#pragma once

#include <functional>

#include "tools/exchange/exported_things.h"
#include "tools/system/progress.h"

namespace umax {

/// Where a clip comes from. Both throw Error when it cannot be had.
struct ClipSource {
  std::function<State(int frame)> state;
  std::function<Camera()> camera;  // that its pictures are taken with
};

struct ExportResult {
  std::vector<std::filesystem::path> files;  // of sequences, their folders
  int signal = 0;                            // that stopped it early; 0: none
};

/// Throws Error (usage) where the format cannot hold these frames, or the options make no sense: for a look before long
/// work.
void check_export(const ExportOptions& options, const std::vector<int>& frames);

/// Writes the frames of the scene's bodies and obstacles into the folder: NAME.ENDING, of sequences NAME/NNNN.ENDING.
/// Files appear whole or not at all. Holds one frame at a time. Throws Error (cannot_create, io_error; bad_data for what
/// the format cannot hold; and what `source` throws).
ExportResult export_clip(const Simulation& simulation, const ClipSource& source, const std::vector<int>& frames,
                         const std::filesystem::path& folder, const ExportOptions& options, Progress& progress);

}  // namespace umax
