// Finds the values of a scene's keys that give what is wanted of its clip: plans, runs, tells and shows.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"
#include "tools/aim/aim_folder.h"
#include "tools/aim/key_range.h"
#include "tools/aim/want.h"
#include "tools/system/progress.h"
#include "tools/trials/trial_runs.h"

namespace umax {

struct AimRequest {
  std::string scene;                     // a file, or the name of a built-in scene
  std::vector<Override> settings = {};   // for all runs
  std::vector<std::string> wants = {};   // see parse_want()
  std::vector<std::string> ranges = {};  // see parse_range()
};

struct AimPlan {
  AimRequest request;
  Scene scene;  // as it is, with the settings
  std::vector<Want> wants;
  std::vector<KeyRange> keys;
  int last_frame = 1;  // that the wants need
  int most_runs = 10;
};

/// Throws Error (usage, bad_data): for --want and --vary, and what load_scene() throws.
AimPlan plan_aim(const AimRequest& request);

inline constexpr int exit_code_not_reached = 3;

/// Runs until the wants are reached, or says why not; writes lines, plots, strip and page. Returns the exit code: 0,
/// exit_code_not_reached, that of a run that failed, or 128 + n after signal n.
int do_aim(const AimPlan& plan, const AimFolder& folder, const TrialOptions& options, Progress& progress);

}  // namespace umax
