#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

int drop_mesh(const Options& options) {
  Job job;
  job.scene = scene_of_mesh(single_input(options, "mesh"), 0.5, options);
  job.folder = output_folder(options, job.scene.name);
  job.existing = existing_folder(options);
  return run_job(job, options);
}

}  // namespace

Verb drop_verb() {
  return {.name = "drop",
          .usage = "MESH",
          .summary = "no scene file: voxelise, drop on the ground, run",
          .details =
              "Puts the mesh into a cage of hexes, drops it on the ground from half its height, renders and encodes. "
              "Stiffness goes with the size, so that a large and a small body sag by the same share of their height.",
          .examples = {"umax drop bunny.ply --height \"20 cm\" --stretch 10%"},
          .arguments = {.endings = {"*"}},
          .options = {"--output",        "--set",      "--frames", "--resume",  "--overwrite", "--strict",
                      "--allow-overlap", "--quick",    "--engine", "--samples", "--size",      "--seed",
                      "--height",        "--unit",     "--up",     "--cells",   "--stretch",   "--threads",
                      "--memory",        "--progress", "--quiet",  "--verbose"},
          .run = drop_mesh};
}

}  // namespace umax
