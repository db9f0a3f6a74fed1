#include <filesystem>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/run/clip.h"
#include "tools/run/frame_list.h"
#include "tools/run/picture_estimate.h"
#include "tools/run/picture_work.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_log.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

void require_pictures(const fs::path& run, const std::vector<int>& frames) {
  std::error_code error;
  for (const int frame : frames)
    if (!fs::exists(picture_path(run, frame), error))
      throw Error(Fault::not_found, {.where = picture_path(run, frame).string(),
                                     .what = "is missing: the clip is made of all frames",
                                     .remedy = "draw it first: umax render " + run.string() + " --resume --frames " +
                                               std::to_string(frame) + "; or give --frames of those that are there"});
}

int logged_clip(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, RunLog& log,
                Progress& progress) {
  try {
    const int signal = make_clip(folder, frames, scene, progress);
    log.write("ended " + (signal == 0 ? "finished" : stop_note(signal)));
    return signal;
  } catch (const Error& error) {
    log.write(std::string("ended error: ") + error.what());
    throw;
  }
}

int encode_run(const Options& options) {
  const fs::path run = single_input(options, "folder of a run");
  const Scene scene = scene_of_run(run, {});
  const std::vector<int> frames =
      options.frames ? parse_frame_list(*options.frames, scene.clip.frames) : all_frames(scene.clip.frames);
  require_even_size(scene.render.width, scene.render.height);
  require_clip_encoder();
  const SignalWatch signals;
  const RunFolder folder(run, ExistingFolder::keep, FolderUse::shared, "encode");
  require_pictures(run, frames);
  Progress progress(stdout, progress_mode(options), options.quiet);
  const std::string cost = announce(PictureJob{.pixels = double(scene.render.width) * scene.render.height,
                                               .clip_frames = int(frames.size()),
                                               .threads = ThreadLimit({}).count()});
  if (!cost.empty()) progress.note(cost);
  RunLog log(progress);
  log.open(folder.log());
  log.write("began umax encode: " + command_text());
  const int signal = logged_clip(folder, frames, scene, log, progress);
  return exit_code_after(signal);
}

}  // namespace

Verb encode_verb() {
  return {
      .name = "encode",
      .usage = "DIR",
      .summary = "the clip from all frames",
      .details =
          "Makes clip.mp4 of the pictures in the run's folder: of all frames of the clip, or of those that --frames "
          "names. A picture that is missing or damaged is an error that names it.",
      .examples = {"umax render falling --no-clip --frames 1-75", "umax encode falling"},
      .arguments = {.folders = true},
      .options = {"--frames", "--deadline", "--progress", "--quiet", "--verbose"},
      .run = encode_run};
}

}  // namespace umax
