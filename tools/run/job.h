// The work that run, simulate, render, turntable and drop share: a folder, its record, the stages one after the other.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/exchange/exported_things.h"
#include "tools/run/picture_work.h"
#include "tools/run/render_frames.h"

namespace umax {

/// What a verb wants done in a run's folder.
struct Job {
  Scene scene;
  std::shared_ptr<const Simulation> simulation = nullptr;  // of the scene, when it is set up already
  std::filesystem::path folder;
  ExistingFolder existing = ExistingFolder::refuse;
  bool simulate = true;
  bool pictures = true;
  bool clip = true;                                       // of the pictures
  bool replace_pictures = false;                          // those that are there go first
  OtherPictures other_pictures = OtherPictures::replace;  // what to do with those of other settings
  std::optional<int> default_frames;                      // how many frames without --frames; unset: the clip's
  std::vector<ExportOptions> exports = {};                // of the states, once they are there
  /// The pictures to make, when they are not those of the folder's own states.
  std::function<RunPictures(const Simulation&, const std::vector<int>& frames)> make_pictures;
};

/// How a job is done, whatever it is.
struct RunOptions {
  std::string verb = {};                   // that run.json says made the run
  std::optional<std::string> frames = {};  // "1-40,50,60-90x2"; none: all of the job
  int threads = 1;                         // that pictures are made with, and that run.json says
  std::optional<long long> memory = {};    // [bytes] that the simulation may take; none: what the machine has to give
  bool strict = false;                     // a step that does not converge ends the run: Error (try_again)
  bool verbose = false;                    // a line per iteration
};

/// Does the job and returns the exit code. Everything that can be wrong is found out before the folder is touched.
int do_job(const Job& job, const RunOptions& options, Progress& progress);

}  // namespace umax
