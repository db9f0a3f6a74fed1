#include "tools/trials/trial_runs.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/pictures/exposure.h"
#include "tools/run/job_estimate.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/setup/simulation_setup.h"
#include "tools/system/machine_memory.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// What is there of a run.
struct Found {
  bool is_other = false;  // another version of it: another scene, mesh or solver
  int states = 0, pictures = 0;
  bool has_ended = false;  // well: nothing that belongs to its states is missing
  bool is_whole = false;   // with pictures and clip, of these very settings
};

/// A run's scene without the lights that it got on its way from a scene that wants some.
Scene before_lighting(Scene of_run, const Scene& wanted) {
  if (!wanted.wants_lights || of_run.obstacles.size() != wanted.obstacles.size()) return of_run;
  of_run.wants_lights = true;
  of_run.lights.clear();
  of_run.render.sky = wanted.render.sky;
  for (std::size_t i = 0; i < of_run.obstacles.size(); ++i) of_run.obstacles[i].fade = wanted.obstacles[i].fade;
  return of_run;
}

/// Whether the run was made with this very scene.
bool is_scene_of(const fs::path& run, const Scene& scene) {
  try {
    return resolved_toml(before_lighting(load_scene((run / "scene.toml").string()), scene)) == resolved_toml(scene);
  } catch (const Error&) {
    return false;  // of another version, or its mesh has changed
  }
}

Found look_for(const Scene& scene, const fs::path& run, bool is_ours) {
  Found found;
  const auto record = read_run_record(run / "run.json");
  std::error_code error;
  if (!record || !fs::exists(run / "scene.toml", error)) return found;
  const bool same_scene = is_scene_of(run, scene);
  found.is_other = !same_scene && !is_ours && set_up(scene).digest != record->model_sha256;
  if (found.is_other) return found;
  found.states = std::min(count_states(run), scene.clip.frames);
  if (same_scene) found.pictures = std::min(count_pictures(run), scene.clip.frames);
  found.has_ended = record->exit_status == 0 && !is_abandoned(run);
  found.is_whole = same_scene && found.has_ended && found.states == scene.clip.frames &&
                   found.pictures == scene.clip.frames && fs::exists(run / "clip.mp4", error);
  return found;
}

/// [bytes] of a run and its pictures; measured: 0.36 GiB with a surface of 116,000 vertices and few hexes.
long long memory_of(const Scene& scene) {
  return (450LL << 20) + (long long)(lattice_memory(size_of(scene))) + 400LL * scene.render.width * scene.render.height;
}

}  // namespace

WorkerOptions worker_options(const TrialOptions& options) {
  WorkerOptions workers;
  workers.threads = options.threads;
  workers.memory = options.memory ? *options.memory : available_memory();
  // all of it for each: what runs beside it has been counted here
  workers.common_words = {"--memory", std::to_string(workers.memory)};
  if (options.strict) workers.common_words.push_back("--strict");
  return workers;
}

std::optional<WorkItem> missing_work(const TrialRun& trial, const Scene& scene, const TrialGoal& goal, bool is_ours,
                                     Progress& progress) {
  const Found found = look_for(scene, trial.run, is_ours);
  const bool is_simulated = found.states >= goal.last_frame && found.has_ended;
  if (found.is_whole || (!goal.pictures && is_simulated)) return std::nullopt;
  if (found.is_other) progress.note(trial.name + ": was made with other settings, and is made anew");
  write_file(trial.scene, resolved_toml(scene));
  WorkItem item;
  item.name = trial.name;
  item.words = {goal.pictures ? "run" : "simulate", trial.scene.string(), "-o", trial.run.string(),
                found.is_other ? "--overwrite" : "--resume"};
  if (goal.last_frame < scene.clip.frames)
    item.words.insert(item.words.end(), {"--frames", "1-" + std::to_string(goal.last_frame)});
  const int last_state = states_for(scene.render, goal.last_frame, scene.clip.frames).last;
  item.frames = last_state + (goal.pictures ? goal.last_frame : 0);
  item.frames_done = std::min(found.states, last_state) + (goal.pictures ? found.pictures : 0);
  item.memory = memory_of(scene);
  return item;
}

void remove_trials(const fs::path& scenes, const fs::path& runs) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(scenes, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".toml" && is_run_folder(runs / entry->path().stem()))
      files.push_back(entry->path());
  for (const fs::path& file : files) fs::remove(file, error);
  remove_if_empty(scenes);
  remove_runs(runs);
}

bool is_record_of(const fs::path& file, const std::string& program) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return false;
  const auto json = nlohmann::json::parse(read_file(file), nullptr, false);
  return json.is_object() && json.value("program", nlohmann::json()) == program;
}

}  // namespace umax
