// What a farm is to make: one run of a scene, or one for each combination of the values that --vary lists, and the jobs
// that make them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

struct FarmRequest {
  std::string scene;                         // a file, or the name of a built-in scene
  std::vector<Override> settings = {};       // for all runs
  std::vector<std::string> variations = {};  // "key=a,b,c": see parse_variation()
  int frames_per_job = 10;                   // that a job draws
  int processors = 0;                        // of a task; 0: as the queue gives them
  std::optional<long long> memory = {};      // [bytes] of a task
  std::optional<std::string> isa = {};       // "avx2": see pin_instruction_set()
  double deadline = 0;                       // [s] after which a call ends and its task is queued again; 0: none
};

struct FarmRun {
  std::string name;   // of the scene, or of the variant
  std::string scene;  // resolved, as TOML
  std::string title;  // the scene's name
};

struct FarmPlan {
  std::string name;           // of the scene
  bool is_varied = false;     // runs have folders of their own in DIR/runs; else DIR is the run
  std::vector<FarmRun> runs;  // all of the same number of frames
  int num_frames = 0;         // of each
  int frames_per_job = 10;    // see FarmRequest
  int processors = 0;         //
  long long memory = 0;       // [bytes] of a task; 0: as the queue gives it
  double deadline = 0;        // [s]; 0: none
  std::string isa = {};       // empty: the best that a machine has
  int num_chunks() const { return (num_frames + frames_per_job - 1) / frames_per_job; }
};

/// Reads the scene once for each run, and sets each up, so that what is wrong with it is found before it waits in a
/// queue. Throws Error: usage for --vary, what load_scene() and set_up() throw.
FarmPlan plan_farm(const FarmRequest& request);

/// Tasks that wait for tasks of other jobs.
enum class Waiting {
  for_none,
  for_all,   // once all tasks of the jobs before have ended well
  for_each,  // each task once the tasks of its own index have
};

/// An array of tasks that run one script.
struct FarmJob {
  std::string name;                // "render-2"
  std::string script;              // "render.sh"
  std::vector<std::string> words;  // behind it; "task" stands for the task's index
  int tasks = 1;
  Waiting waiting = Waiting::for_none;
  std::vector<std::size_t> after = {};  // which of the jobs before
};

/// The jobs in the order in which they are submitted. Of one run: a simulation, an array with a task for each chunk of
/// its frames, which waits for the whole of it, and the clip. Of several: arrays with a task for each run, in which each
/// waits for its own.
std::vector<FarmJob> jobs_of(const FarmPlan& plan);

}  // namespace umax
