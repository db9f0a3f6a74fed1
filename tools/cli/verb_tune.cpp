#include <fmt/format.h>

#include "core/base/error.h"
#include "tools/cli/verbs.h"
#include "tools/run/clip.h"
#include "tools/run/job.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"
#include "tools/tune/tune_page.h"
#include "tools/tune/tuning.h"

namespace umax {
namespace {

/// The scene that is named, or the one that materials are compared on.
std::string scene_to_tune(const Options& options) {
  return options.inputs.empty() && options.presets ? "materials" : single_input(options, "scene");
}

/// What the pictures are shown with, looked for before the first step.
void require_helpers(const TunePlan& plan) {
  const RenderDescription& render = plan.variants.front().scene.render;
  require_even_size(render.width, render.height);
  require_clip_encoder();
  require_page_encoder();
  plotting_library();
}

}  // namespace

int verb_tune(const Options& options) {
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, options.progress, options.quiet);
  const TunePlan plan = plan_tuning(scene_to_tune(options), options);
  require_helpers(plan);
  const TuneFolder folder(output_folder(options, plan.scene_name + "-tune"), options.existing_folder());
  if (!plan.notes.empty())
    progress.note(fmt::format("preview: {}; --final for the scene as it is", fmt::join(plan.notes, ", ")));
  const SignalWatch watch;
  return do_tuning(plan, folder, options, threads.count(), progress);
}

}  // namespace umax
