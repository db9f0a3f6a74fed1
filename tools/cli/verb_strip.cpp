#include <fmt/format.h>

#include <filesystem>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/pictures/painter.h"
#include "tools/pictures/strip.h"
#include "tools/run/frame_list.h"
#include "tools/run/run_folder.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// One item for every run and frame, in the order of the command line.
std::vector<StripItem> items_of(const Options& options) {
  if (options.inputs.empty())
    throw Error(Fault::usage, {.what = "umax strip takes folders of runs", .remedy = "see umax help strip"});
  std::vector<StripItem> items;
  for (const std::string& run : options.inputs) {
    Scene scene = scene_of_run(run, scene_overrides(options));
    if (!items.empty()) scene.render = items.front().simulation->scene.render;
    const auto simulation = std::make_shared<const Simulation>(set_up(scene));
    const int count = count_states(run);
    for (const int frame : options.frames ? parse_frame_list(*options.frames) : std::vector<int>{count}) {
      if (frame < 1 || frame > count)
        throw Error(Fault::not_found, {.where = state_path(run, frame).string(),
                                       .what = "there is no state of this frame",
                                       .remedy = fmt::format("the run has {} states", count)});
      items.push_back({simulation, read_state(state_path(run, frame), simulation->model, simulation->digest), {}});
    }
  }
  if (!options.labels.empty() && options.labels.size() != items.size())
    throw Error(Fault::usage,
                {.where = "--label",
                 .what = fmt::format("needs one label for each of the {} things in the strip, or none", items.size()),
                 .value = std::to_string(options.labels.size()),
                 .remedy = "give it once for each, from left to right"});
  for (std::size_t i = 0; i < options.labels.size(); ++i) items[i].label = options.labels[i];
  return items;
}

int paint_strip(const Options& options) {
  const ThreadLimit threads(options.threads);
  const fs::path path = options.output.value_or("strip.png");
  require_new_file(path, options);
  const std::vector<StripItem> items = items_of(options);
  const RenderDescription& render = items.front().simulation->scene.render;
  const RenderScene strip = make_strip(items, double(render.width) / render.height);
  const SignalWatch watch;
  if (!Painter(render, threads.count()).paint(strip, path)) return exit_code_after(stop_signal());
  if (!options.quiet) fmt::print("strip: {}\n", path.string());
  return 0;
}

}  // namespace

Verb strip_verb() {
  return {.name = "strip",
          .usage = "DIR...",
          .summary = "one picture of several instants or runs",
          .details =
              "Puts the bodies of several runs, or of several frames of a run, side by side on one ground into one "
              "picture, with the first run's camera direction, lights and heat map. Without --frames, the last frame "
              "of each.",
          .examples = {"umax strip falling --frames 30,50,70,120 -o falling.png --size 1280x440",
                       "umax strip soft stiff --frames 60 --label soft --label stiff --set render.heatmap=stretch"},
          .arguments = {.folders = true},
          .options = {"--output", "--set", "--frames", "--overwrite", "--quick", "--engine", "--samples", "--size",
                      "--seed", "--label", "--threads", "--quiet", "--verbose"},
          .run = paint_strip};
}

}  // namespace umax
