#include "core/base/error.h"
#include "tools/cli/mesh_scene.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

Scene scene_to_drop(const Options& options) {
  if (options.inputs.empty())
    throw Error(Fault::usage, {.what = "umax drop takes a mesh, or several", .remedy = "see umax help drop"});
  const std::vector<std::filesystem::path> paths(options.inputs.begin(), options.inputs.end());
  const int count = options.count.value_or(int(paths.size()));
  if (count == 1 && paths.size() == 1) return scene_of_mesh(paths.front(), 0.5, options);
  return scene_of_meshes(paths, count, options);
}

int drop_meshes(const Options& options) {
  Job job;
  job.scene = scene_to_drop(options);
  job.folder = output_folder(options, job.scene.name);
  job.existing = existing_folder(options);
  job.exports = job_exports(options);
  return run_job(job, options);
}

}  // namespace

Verb drop_verb() {
  return {
      .name = "drop",
      .usage = "MESH...",
      .summary = "no scene file: voxelise, drop on the ground, run",
      .details =
          "Puts the mesh into a cage of hexes, drops it on the ground from half its height, renders and encodes. "
          "Stiffness goes with the size, so that a large and a small body sag by the same share of their height.\n\n"
          "Several meshes fall together, on the ground and on each other; with --count so many bodies in all, the "
          "meshes taken in turn. They start above each other, apart and variously turned, and are named after "
          "their files: body.bunny, or body.bunny_1, body.bunny_2 where there are several.",
      .examples = {"umax drop bunny.ply --height \"20 cm\" --stretch 10%",
                   "umax drop cow.obj pig.obj --count 30 --height \"1 m\""},
      .arguments = {.endings = {"*"}},
      .options = {"--output",        "--set",     "--frames",  "--resume", "--overwrite", "--deadline", "--strict",
                  "--allow-overlap", "--quick",   "--no-clip", "--export", "--engine",    "--samples",  "--size",
                  "--seed",          "--height",  "--unit",    "--up",     "--cells",     "--count",    "--stretch",
                  "--stage",         "--threads", "--isa",     "--memory", "--progress",  "--quiet",    "--verbose"},
      .run = drop_meshes};
}

}  // namespace umax
