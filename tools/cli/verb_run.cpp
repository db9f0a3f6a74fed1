#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

int run_scene(const Options& options) {
  Job job;
  job.scene = load_scene(single_input(options, "scene"), scene_overrides(options));
  job.folder = output_folder(options, job.scene.name);
  job.existing = existing_folder(options);
  job.exports = job_exports(options);
  return run_job(job, options);
}

}  // namespace

Verb run_verb() {
  return {
      .name = "run",
      .usage = "SCENE",
      .summary = "simulate, render, encode: the whole clip",
      .details =
          "Simulates the scene, renders its frames and encodes DIR/clip.mp4. DIR/states, DIR/frames and "
          "DIR/steps.csv stay for later use by umax render, turntable and inspect.",
      .examples = {"umax run figure -o falling --size 640x360",
                   "umax run beam --set body.beam.limit.energy=0.1J --set clip.frames=60"},
      .arguments = {.words = scene_names, .endings = {"toml"}, .folders = true},
      .options = {"--output",        "--set",     "--frames",  "--resume", "--overwrite", "--deadline", "--strict",
                  "--allow-overlap", "--quick",   "--no-clip", "--export", "--engine",    "--samples",  "--size",
                  "--seed",          "--threads", "--isa",     "--memory", "--progress",  "--quiet",    "--verbose"},
      .run = run_scene};
}

}  // namespace umax
