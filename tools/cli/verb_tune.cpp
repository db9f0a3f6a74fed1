#include <fmt/format.h>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/run/clip.h"
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

int tune(const Options& options) {
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), options.quiet);
  const TunePlan plan = plan_tuning({.scene = scene_to_tune(options),
                                     .settings = scene_overrides(options),
                                     .variations = options.variations,
                                     .presets = options.presets,
                                     .final = options.final});
  require_helpers(plan);
  const TuneFolder folder(output_folder(options, plan.scene_name + "-tune"), existing_folder(options));
  if (!plan.notes.empty())
    progress.note(fmt::format("preview: {}; --final for the scene as it is", fmt::join(plan.notes, ", ")));
  const SignalWatch watch;
  const TrialOptions runs{.threads = threads.count(), .memory = memory_limit(options), .strict = options.strict};
  return do_tuning(plan, folder, runs, progress);
}

}  // namespace

Verb tune_verb() {
  return {.name = "tune",
          .usage = "SCENE",
          .summary = "variants of a scene side by side",
          .details =
              "Runs the scene once for every combination of the values that --vary lists, several at a time as cores "
              "and memory allow, and writes DIR/tune.html, a page with all variants in step under one scrubber, their "
              "plots and values, and lines to copy into the scene; DIR/sheet.png, the moment at which they are "
              "stretched most; and DIR/variants.mp4. Each variant is a run of its own in DIR/runs. The page opens from "
              "the disk in any browser.\n\nWithout --final it is a preview: small pictures of few paths, cages of 400 "
              "hexes at most; what it changes is said, and never what you set or vary. A variant that fails does not "
              "end the others; the exit code is then its own. With --resume only what is missing is made. --presets "
              "compares all materials (umax presets), without a SCENE on the scene materials. The plots need "
              "libjs-chart.js; the environment's UMAX_JAVASCRIPT may name another folder of it.",
          .examples = {"umax tune figure --vary body.figure.limit.stretch=5%,10%,15%,40%",
                       "umax tune figure --vary body.figure.limit.stretch=5%,20% --vary "
                       "body.figure.material.young=\"50 kPa,200 kPa\"",
                       "umax tune --presets"},
          .arguments = {.words = scene_names, .endings = {"toml"}, .folders = true},
          .options = {"--output",  "--set",     "--resume", "--overwrite", "--deadline", "--strict",  "--allow-overlap",
                      "--engine",  "--samples", "--size",   "--seed",      "--vary",     "--presets", "--final",
                      "--threads", "--isa",     "--memory", "--progress",  "--quiet",    "--verbose"},
          .run = tune};
}

}  // namespace umax
