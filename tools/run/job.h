// The work that run, simulate, render, turntable and drop share: a folder, its record, the stages one after the other.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene_document.h"
#include "tools/run/options.h"
#include "tools/run/render_frames.h"
#include "tools/run/run_record.h"

namespace umax {

/// What a verb wants done in a run's folder.
struct Job {
  Scene scene;
  std::shared_ptr<const Simulation> simulation = nullptr;  // of the scene, when it is set up already
  std::filesystem::path folder;
  ExistingFolder existing = ExistingFolder::refuse;
  bool simulate = true;
  bool pictures = true;               // and the clip
  bool replace_pictures = false;      // those that are there go first
  std::optional<int> default_frames;  // how many frames without --frames; unset: the clip's
  /// The pictures to make, when they are not those of the folder's own states.
  std::function<RunPictures(const Simulation&, const std::vector<int>& frames)> make_pictures;
};

/// Does the job and returns the exit code. Everything that can be wrong is found out before the folder is touched.
int do_job(const Job& job, const Options& options);

/// The options --engine, --samples, --size, --seed and --quick as settings of the scene, behind those of --set.
std::vector<Override> scene_overrides(const Options& options);

/// Throws Error (cannot_create) when a file is there that may not be overwritten.
void require_new_file(const std::filesystem::path& path, bool overwrite);

/// The only input; throws Error (usage) when there is none or more than one.
std::string single_input(const Options& options, const std::string& what);

/// -o, or ./NAME.
std::filesystem::path output_folder(const Options& options, const std::string& name);

}  // namespace umax
