// A run's states, exported.
#pragma once

#include "tools/exchange/export_clip.h"

namespace umax {

/// Exports these frames of a run's folder and says where they are. Throws Error: not_found where a state is missing,
/// bad_data where one is damaged or another scene's, and what export_clip() throws.
ExportResult export_run(const Simulation& simulation, const std::filesystem::path& run, const std::vector<int>& frames,
                        const std::filesystem::path& folder, const ExportOptions& options, Progress& progress);

}  // namespace umax
