#include "tools/farm/farm_status.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "tools/farm/farm_folder.h"
#include "tools/farm/farm_record.h"
#include "tools/farm/job_queue.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr int cannot_write = 74, ended_by_signal = 128;  // exit codes, as task_functions.sh has them

FarmRunStatus status_of_run(const std::string& name, const fs::path& run, int num_frames) {
  FarmRunStatus status{.name = name};
  std::error_code error;
  status.states = count_states(run);
  for (int frame = 1; frame <= num_frames; ++frame) status.pictures += fs::exists(picture_path(run, frame), error);
  status.has_clip = fs::exists(run / "clip.mp4", error);
  return status;
}

/// Of one task: lines "TIME HOST begins" and "TIME HOST CODE", in turns unless the task itself was killed.
void count_calls(const fs::path& file, FarmStatus& status) {
  std::istringstream lines(read_file(file));
  int open = 0;  // lost, and no later call has ended well so far
  bool is_running = false;
  for (std::string time, host, word; lines >> time >> host >> word;) {
    const bool begins = word == "begins";
    const int code = begins ? 0 : std::atoi(word.c_str());
    const bool is_lost = begins ? is_running : code == cannot_write || code > ended_by_signal;
    if (begins) ++status.calls;
    if (is_lost) ++status.lost, ++open;
    if (!begins && code == 0) status.recovered += std::exchange(open, 0);
    is_running = begins;
  }
}

void ask_queue(const FarmRecord& record, const fs::path& functions, FarmStatus& status) {
  try {
    const QueueFunctions queue = read_file(functions);
    require_queue(queue);
    for (const QueuedTask& task : unfinished_tasks(record, queue)) ++status.tasks[task.state];
  } catch (const Error& error) {
    status.queue_problem = error.what();
  }
}

/// What to do when something is missing and no job is left that makes it.
std::string remedy(const FarmStatus& status, const fs::path& folder) {
  const std::string again = status.command + (status.command.find("--resume") == std::string::npos ? " --resume" : "");
  return fmt::format(
      "no job is left in the queue, and not all is there: {} says why, and this goes on where it ended:\n  {}\n",
      (folder / "farm" / "logs").string(), again);
}

}  // namespace

bool FarmStatus::is_whole() const {
  return std::all_of(runs.begin(), runs.end(), [&](const FarmRunStatus& run) {
    return run.states >= num_frames && run.pictures == num_frames && run.has_clip;
  });
}

FarmStatus farm_status(const fs::path& folder) {
  const FarmRecord record = read_farm_record(farm_paths(folder, false).record());
  const FarmPaths paths = farm_paths(folder, record.is_varied);
  FarmStatus status{.name = record.name, .num_frames = record.num_frames, .command = record.command};
  for (const std::string& run : record.runs)
    status.runs.push_back(status_of_run(run, paths.run(run), record.num_frames));
  std::error_code error;
  for (fs::directory_iterator entry(paths.calls(), error), end; !error && entry != end; entry.increment(error))
    count_calls(entry->path(), status);
  ask_queue(record, paths.queue(), status);
  return status;
}

std::string farm_status_text(const FarmStatus& status, const fs::path& folder) {
  std::string text;
  for (const FarmRunStatus& run : status.runs)
    text +=
        fmt::format("{}: {} of {} states, {} of {} pictures, {}\n", run.name, std::min(run.states, status.num_frames),
                    status.num_frames, run.pictures, status.num_frames, run.has_clip ? "clip" : "no clip yet");
  std::string queued;
  for (const auto& [state, count] : status.tasks)
    queued += fmt::format("{}{} {}", queued.empty() ? "" : ", ", count, state);
  if (!status.queue_problem.empty())
    text += "queue: not known: " + status.queue_problem + "\n";
  else
    text += "queue: " + (queued.empty() ? "no task is left" : queued) + "\n";
  text +=
      fmt::format("calls of umax: {}; lost: {}, of which {} recovered\n", status.calls, status.lost, status.recovered);
  if (status.is_whole())
    text += "all is there\n";
  else if (status.queue_problem.empty() && queued.empty())
    text += remedy(status, folder);
  return text;
}

std::string farm_status_json(const FarmStatus& status) {
  nlohmann::ordered_json json{{"name", status.name}, {"frames", status.num_frames}, {"whole", status.is_whole()}};
  json["runs"] = nlohmann::ordered_json::array();
  for (const FarmRunStatus& run : status.runs)
    json["runs"].push_back(
        {{"name", run.name}, {"states", run.states}, {"pictures", run.pictures}, {"clip", run.has_clip}});
  json["tasks"] = status.tasks;
  if (!status.queue_problem.empty()) json["queue_problem"] = status.queue_problem;
  json["calls"] = status.calls;
  json["lost"] = status.lost;
  json["recovered"] = status.recovered;
  return json.dump(2) + "\n";
}

}  // namespace umax
