#include "tools/cli/mesh_scene.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/live/live.h"
#include "tools/system/threads.h"

namespace umax {
namespace {

int live(const Options& options) {
  const std::string input = single_input(options, "scene or mesh");
  const Scene scene = kind_of_input(input) == InputKind::mesh ? scene_of_mesh(input, 0.5, options)
                                                              : load_scene(input, scene_overrides(options));
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), false);
  return run_live(scene,
                  {.folder = output_folder(options, scene.name + "-live"),
                   .existing = existing_folder(options),
                   .port = options.port.value_or(0),
                   .keep = options.keep.value_or(LiveOptions().keep),
                   .browser = !options.no_browser},
                  progress);
}

}  // namespace

Verb live_verb() {
  return {
      .name = "live",
      .usage = "SCENE|MESH",
      .summary = "real-time tuning in a browser, loopback only",
      .details =
          "Serves a page on 127.0.0.1 that shows the scene in motion: turn limits, stiffness, damping and gravity "
          "while "
          "the body falls, pull at it with the mouse, go back and on again. The address stands in the terminal; it "
          "opens "
          "once, and a new one is said for the next browser.\n\nA session is saved as a scene that umax simulate runs "
          "again to the same bits, or as a run's folder that umax render takes. Ctrl-C ends it and keeps the session.",
      .examples = {"umax live figure", "umax live bunny.ply --height \"20 cm\" --cells 200",
                   "umax live figure --port 8123 --no-browser"},
      .arguments = {.words = scene_names, .endings = {"*"}},
      .options = {"--output", "--set", "--overwrite", "--port", "--no-browser", "--keep", "--height", "--unit", "--up",
                  "--cells", "--stretch", "--allow-overlap", "--threads", "--progress"},
      .run = live};
}

}  // namespace umax
