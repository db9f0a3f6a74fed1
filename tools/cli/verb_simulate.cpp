#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

int simulate_scene(const Options& options) {
  Job job;
  job.scene = load_scene(single_input(options, "scene"), scene_overrides(options));
  job.folder = output_folder(options, job.scene.name);
  job.existing = existing_folder(options);
  job.exports = job_exports(options);
  job.pictures = false;
  return run_job(job, options);
}

}  // namespace

Verb simulate_verb() {
  return {
      .name = "simulate",
      .usage = "SCENE",
      .summary = "states and steps.csv only",
      .details =
          "Writes one state per frame and one row of steps.csv per time step, and draws the rows in DIR/plots. With "
          "--resume it goes on from the last whole state; the result is the same to the last bit as without the break.",
      .examples = {"umax simulate armadillo --set body.armadillo.mesh=armadillo.obj --frames 1-100"},
      .arguments = {.words = scene_names, .endings = {"toml"}, .folders = true},
      .options = {"--output", "--set", "--frames", "--resume", "--overwrite", "--deadline", "--strict",
                  "--allow-overlap", "--export", "--threads", "--isa", "--memory", "--progress", "--quiet",
                  "--verbose"},
      .run = simulate_scene};
}

}  // namespace umax
