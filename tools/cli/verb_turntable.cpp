#include <filesystem>

#include "core/base/error.h"
#include "tools/cli/mesh_scene.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr int circle_frames = 120;
constexpr double circle_fps = 30;

fs::path name_of_run(const fs::path& run) {
  const fs::path full = fs::absolute(run).lexically_normal();
  return full.has_filename() ? full.filename() : full.parent_path().filename();
}

/// The frame of the run that stands still: the chosen or the last one.
int still_frame(const fs::path& run, const Options& options) {
  const int count = count_states(run);
  const int frame = options.still.value_or(count);
  if (frame >= 1 && frame <= count) return frame;
  throw Error(Fault::not_found,
              {.where = state_path(run, frame).string(),
               .what = "there is no state of this frame",
               .remedy = "the run has " + std::to_string(count) + " states; choose one with --still"});
}

int turn(const Options& options) {
  const std::string input = single_input(options, "mesh, scene or folder of a run");
  const InputKind kind = kind_of_input(input);
  if (kind != InputKind::run && options.still)
    throw Error(Fault::usage, {.where = "--still", .what = "is for the folder of a run", .remedy = "leave it out"});

  if (kind != InputKind::mesh && options.stage)
    throw Error(Fault::usage, {.where = "--stage",
                               .what = "is for a mesh: a scene brings its own ground, lights and sky",
                               .value = *options.stage,
                               .remedy = "leave it out, or set [light] and [render]"});

  Job job;
  job.simulate = false;
  std::string name;
  int still = 0;
  if (kind == InputKind::run) {
    job.scene = scene_of_run(input, scene_overrides(options));
    still = still_frame(input, options);
    name = name_of_run(input).string() + "-turntable";
  } else if (kind == InputKind::mesh) {
    Options circle = options;
    circle.settings.insert(circle.settings.begin(),
                           {"clip.frames=" + std::to_string(circle_frames), "clip.fps=" + std::to_string(circle_fps)});
    job.scene = scene_of_mesh(input, 0, circle);
    name = job.scene.name;
  } else {
    job.scene = load_scene(input, scene_overrides(options));
    name = job.scene.name;
  }
  job.folder = output_folder(options, name);
  job.existing = existing_folder(options);
  job.make_pictures = [input, still](const Simulation& simulation, const std::vector<int>& frames) {
    const State state = still > 0 ? read_state(state_path(input, still), simulation.model, simulation.digest)
                                  : rest_state(simulation.model);
    return turntable_of(simulation, state, frames);
  };
  return run_job(job, options);
}

}  // namespace

Verb turntable_verb() {
  return {.name = "turntable",
          .usage = "MESH|SCENE|DIR",
          .summary = "camera circles a still or a chosen frame",
          .details =
              "Circles a mesh, a scene's first instant, or one frame of a run once around. clip.frames is the number "
              "of pictures.",
          .examples = {"umax turntable bunny.ply --height \"20 cm\"", "umax turntable falling --still 60"},
          .arguments = {.words = scene_names, .endings = {"*"}},
          .options = {"--output",  "--set",    "--frames",  "--resume",  "--overwrite", "--deadline", "--quick",
                      "--no-clip", "--engine", "--samples", "--size",    "--seed",      "--still",    "--height",
                      "--unit",    "--up",     "--stage",   "--threads", "--progress",  "--quiet",    "--verbose"},
          .run = turn};
}

}  // namespace umax
