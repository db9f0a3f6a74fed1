// Runs of a scene with other values, each in a folder of its own: what of them is there, and what is left to do.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scenes/scene.h"
#include "tools/system/progress.h"
#include "tools/trials/workers.h"

namespace umax {

/// What the runs get of the machine, and what they are told.
struct TrialOptions {
  int threads = 1;                       // of all together
  std::optional<long long> memory = {};  // [bytes] of all together; none: what the machine has to give
  bool strict = false;                   // a step that does not converge ends its run
};

/// The same for the workers that do them.
WorkerOptions worker_options(const TrialOptions& options);

/// What is to be there of a run.
struct TrialGoal {
  int last_frame = 0;     // of its states
  bool pictures = false;  // and all pictures, and the clip
};

struct TrialRun {
  std::string name;             // for messages
  std::filesystem::path scene;  // the file that it is made of
  std::filesystem::path run;
};

/// The work that is missing for the goal; nothing where all is there. Writes the scene's file. is_ours: its states were
/// made or found to be this scene's just now; only what it is seen by may have changed. Otherwise a run that is there and
/// is another scene's is made anew, and that is noted.
std::optional<WorkItem> missing_work(const TrialRun& trial, const Scene& scene, const TrialGoal& goal, bool is_ours,
                                     Progress& progress);

/// Removes the scenes' files and their runs, and no other file.
void remove_trials(const std::filesystem::path& scenes, const std::filesystem::path& runs);

/// Whether the file is JSON whose "program" is this one: what a verb leaves in its folder to know it again.
bool is_record_of(const std::filesystem::path& file, const std::string& program);

}  // namespace umax
