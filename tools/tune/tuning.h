// Runs the variants of a scene and writes what shows them side by side.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene.h"
#include "tools/run/options.h"
#include "tools/tune/tune_folder.h"
#include "tools/tune/variants.h"

namespace umax {

/// A variant as it is to be run.
struct TuneVariant {
  SceneVariant variant;
  Scene scene;  // with the preview's settings
  std::string snippet;
};

struct TunePlan {
  std::string scene_name;
  std::vector<Variation> variations;
  std::vector<TuneVariant> variants;
  std::vector<std::string> notes;  // on the preview
};

/// Reads the scene once for each variant. Throws Error: usage for --vary, what load_scene() throws, and for scenes
/// whose variants cannot be shown in step (another number of frames, rate or size).
TunePlan plan_tuning(const std::string& scene, const Options& options);

/// Runs what is missing and writes sheet, clip and page; returns the exit code: 0, that of the first variant that
/// failed, or 128 + n after signal n. Throws Error when nothing can be shown.
int do_tuning(const TunePlan& plan, const TuneFolder& folder, const Options& options, int threads, Progress& progress);

}  // namespace umax
