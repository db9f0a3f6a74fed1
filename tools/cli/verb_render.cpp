#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/pictures/exposure.h"
#include "tools/run/picture_work.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

bool has_pictures(const fs::path& run) {
  std::error_code error;
  const fs::directory_iterator entries(run / "frames", error);
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) { return entry.path().extension() == ".png"; });
}

/// The run's own folder exists by rights: only pictures that are there, and that nobody is drawing, need a word of the
/// user's.
void render_in_place(const fs::path& run, const Options& options, Job& job) {
  job.folder = run;
  job.existing = ExistingFolder::keep;
  job.replace_pictures = options.overwrite;
  if (has_pictures(run) && drawing_in(run).empty() && !options.resume && !options.overwrite)
    throw Error(
        Fault::cannot_create,
        {.where = (run / "frames").string(),
         .what = "holds pictures already",
         .remedy = "go on with them by --resume, replace them by --overwrite, or choose another folder with -o"});
}

int render_run(const Options& options) {
  const fs::path run = single_input(options, "folder of a run");
  Job job;
  job.scene = scene_of_run(run, scene_overrides(options));
  job.simulate = false;
  job.default_frames = last_frame_with(job.scene.render, count_states(run), job.scene.clip.frames);
  if (*job.default_frames == 0)
    throw Error(Fault::not_found, {.where = (run / "states").string(),
                                   .what = "there are no states",
                                   .remedy = "simulate first: umax simulate SCENE -o " + run.string()});

  std::error_code error;
  const bool in_place = !options.output || fs::equivalent(*options.output, run, error);
  if (in_place) {
    render_in_place(run, options, job);
  } else {
    job.folder = *options.output;
    job.existing = drawing_in(job.folder).empty() ? existing_folder(options) : ExistingFolder::keep;
  }
  job.other_pictures = OtherPictures::refuse;
  job.make_pictures = [run](const Simulation& simulation, const std::vector<int>& frames) {
    return pictures_of_run(simulation, run, frames);
  };
  return run_job(job, options);
}

}  // namespace

Verb render_verb() {
  return {
      .name = "render",
      .usage = "DIR",
      .summary = "frames (and clip) from the states in DIR",
      .details =
          "Renders the frames whose states are in the run's folder, and encodes the clip. With -o the pictures go "
          "into another folder. Called several times at once, on one or on several machines that share the folder, "
          "the calls share the frames: none is drawn twice, those of a call that dies are drawn by the others, and "
          "one makes the clip of all. They must draw with the same settings. A call with --frames makes the clip of "
          "these, if nobody shares the work.",
      .examples = {"umax render falling --overwrite --engine osmesa --set render.heatmap=energy",
                   "umax render falling --resume"},
      .arguments = {.folders = true},
      .options = {"--output", "--set", "--frames", "--resume", "--overwrite", "--deadline", "--quick", "--no-clip",
                  "--engine", "--samples", "--size", "--seed", "--threads", "--progress", "--quiet", "--verbose"},
      .run = render_run};
}

}  // namespace umax
