#include "tools/farm/farm.h"

#include <fmt/format.h>

#include <functional>
#include <set>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/farm/farm_folder.h"
#include "tools/farm/farm_record.h"
#include "tools/farm/farm_scripts.h"
#include "tools/run/clip.h"
#include "tools/run/run_log.h"
#include "tools/system/version.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// What a job waits for, by the numbers of those before it.
std::string after_text(const FarmJob& job, const std::vector<std::string>& ids) {
  if (job.waiting == Waiting::for_none) return "-";
  std::string text = job.waiting == Waiting::for_all ? "all" : "each";
  for (const std::size_t before : job.after) text += ":" + ids[before];
  return text;
}

QueueJob queue_job(const FarmJob& job, const FarmPaths& paths, const std::vector<std::string>& ids) {
  QueueJob queued{.name = job.name, .tasks = job.tasks, .after = after_text(job, ids), .words = {}};
  queued.words.push_back((paths.farm() / job.script).string());
  queued.words.insert(queued.words.end(), job.words.begin(), job.words.end());
  return queued;
}

/// This program, as other machines find it.
std::string program_path() {
  return fs::read_symlink("/proc/self/exe").string();
}

FarmRecord record_of(const FarmPlan& plan) {
  FarmRecord record{.version = version_text(),
                    .command = command_text(),
                    .name = plan.name,
                    .is_varied = plan.is_varied,
                    .num_frames = plan.num_frames,
                    .frames_per_job = plan.frames_per_job,
                    .runs = {},
                    .jobs = {}};
  for (const FarmRun& run : plan.runs) record.runs.push_back(run.name);
  return record;
}

/// Takes back what was submitted before one was refused. What does not work here is in the error's text.
[[noreturn]] void take_back(const QueueFunctions& queue, const std::vector<std::string>& ids, const Error& error) {
  ErrorText text = error.text();
  try {
    if (!ids.empty()) cancel_jobs(queue, ids);
  } catch (const Error& second) {
    text.what +=
        fmt::format("; the jobs before it ({}) could not be cancelled: {}", fmt::join(ids, ", "), second.text().what);
  }
  throw Error(error.fault(), text);
}

}  // namespace

void submit_farm(const FarmPlan& plan, const fs::path& folder, ExistingFolder existing, const QueueFunctions& queue,
                 Progress& progress) {
  require_queue(queue);
  require_clip_encoder();
  if (existing != ExistingFolder::refuse) require_no_jobs(folder);
  const FarmPaths paths = make_farm_folder(plan, folder, existing);
  for (const FarmScript& script : farm_scripts(plan, paths, queue, program_path()))
    write_file(paths.farm() / script.name, script.text);
  FarmRecord record = record_of(plan);
  write_farm_record(paths.record(), record);

  std::vector<std::string> ids;
  for (const FarmJob& job : jobs_of(plan)) {
    try {
      ids.push_back(submit_job(queue, queue_job(job, paths, ids)));
    } catch (const Error& error) {
      take_back(queue, ids, error);
    }
    record.jobs.push_back({job.name, ids.back(), job.tasks});
    // at once: should we end here, cancel and status know what is in the queue
    write_farm_record(paths.record(), record);
    progress.note(fmt::format("{}: job {}, {} task{}", job.name, ids.back(), job.tasks, job.tasks == 1 ? "" : "s"));
  }
  progress.note(fmt::format("umax farm status {} says how far it is", folder.string()));
}

std::string farm_dry_run(const FarmPlan& plan, const fs::path& folder, const QueueFunctions& queue) {
  const FarmPaths paths = farm_paths(folder, plan.is_varied);
  std::string text;
  for (const FarmScript& script : farm_scripts(plan, paths, queue, program_path()))
    text += fmt::format("### {}\n{}\n", (paths.farm() / script.name).string(), script.text);
  text += "### what is submitted; names stand for the numbers that the queue gives\n";
  std::vector<std::string> names;
  for (const FarmJob& job : jobs_of(plan)) {
    text += fmt::format("{}: {}\n", job.name, submit_command(queue, queue_job(job, paths, names)));
    names.push_back(job.name);
  }
  return text;
}

int cancel_farm(const fs::path& folder) {
  const FarmPaths paths = farm_paths(folder, false);
  const FarmRecord record = read_farm_record(paths.record());
  const QueueFunctions queue = read_file(paths.queue());
  require_queue(queue);
  const std::vector<QueuedTask> tasks = unfinished_tasks(record, queue);
  std::set<std::string> jobs;
  for (const QueuedTask& task : tasks) jobs.insert(task.job);
  if (!jobs.empty()) cancel_jobs(queue, {jobs.begin(), jobs.end()});
  return int(tasks.size());
}

}  // namespace umax
