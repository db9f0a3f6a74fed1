// aim.html: one file that shows a search, needs no other and no network; and the same as numbers.
#pragma once

#include <string>

#include "tools/aim/aim_runs.h"

namespace umax {

/// What the page says beside the runs.
struct AimReport {
  bool reached = false;
  std::string verdict, lines, command;  // lines for the scene; the command that runs it
};

std::string aim_page_html(const AimPlan& plan, const AimFolder& folder, const AimRuns& runs, const AimRun& best,
                          const AimReport& report);

/// The numbers of the page, for scripts: aim.json.
std::string aim_record(const AimPlan& plan, const AimRuns& runs, const AimRun& best, const AimReport& report);

}  // namespace umax
