// Runs the variants of a scene and writes what shows them side by side.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"
#include "tools/system/progress.h"
#include "tools/trials/trial_runs.h"
#include "tools/trials/variants.h"
#include "tools/tune/tune_folder.h"

namespace umax {

/// What is to be put side by side.
struct TuneRequest {
  std::string scene;                         // a file, or the name of a built-in scene
  std::vector<Override> settings = {};       // for all variants
  std::vector<std::string> variations = {};  // "key=a,b,c": see parse_variation()
  bool presets = false;                      // vary material.preset over all presets
  bool final = false;                        // the scene as it is, not a preview of it
};

/// A variant as it is to be run.
struct TuneVariant {
  SceneVariant variant;
  Scene scene;  // with the preview's settings
  std::string snippet;
  std::string aim;  // see aim_command()
};

struct TunePlan {
  std::string scene_name;
  std::vector<Variation> variations;
  std::vector<TuneVariant> variants;
  std::vector<std::string> notes;  // on the preview
};

/// Reads the scene once for each variant. Throws Error: usage for --vary, what load_scene() throws, and for scenes
/// whose variants cannot be shown in step (another number of frames, rate or size).
TunePlan plan_tuning(const TuneRequest& request);

/// Runs what is missing and writes sheet, clip and page; returns the exit code: 0, that of the first variant that
/// failed, or 128 + n after signal n. Throws Error when nothing can be shown.
int do_tuning(const TunePlan& plan, const TuneFolder& folder, const TrialOptions& options, Progress& progress);

}  // namespace umax
