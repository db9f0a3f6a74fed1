// What shows a search: wants against keys, and the body before and after.
#pragma once

#include <string>

#include "tools/aim/aim_runs.h"

namespace umax {

/// One panel a want, over the values of a key: the runs, what was wanted, and the best run. SVG.
std::string draw_aim_plot(const AimPlan& plan, std::size_t key, const AimRuns& runs, const AimRun& best);

/// The scene as it is beside the best run, at the frames of the wants. False when a signal stopped it.
bool write_before_after(const AimPlan& plan, const AimFolder& folder, const AimRuns& runs, const AimRun& best,
                        int threads);

}  // namespace umax
