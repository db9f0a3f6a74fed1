// How a search ended, in words.
#pragma once

#include <string>

#include "tools/aim/aim_runs.h"

namespace umax {

/// One sentence or two: that it was reached and by what, or why not, with the nearest that was.
std::string verdict_text(const AimPlan& plan, const AimResult& result, const AimRuns& runs);

/// "stretch 8.31 %" of a run; of the scene as it is, its own values.
std::string values_text(const AimPlan& plan, const AimRun& run);

/// The run's values as settings, those of the scene as it is included.
std::vector<Override> found_settings(const AimPlan& plan, const AimRun& run);

}  // namespace umax
