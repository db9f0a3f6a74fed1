#include "tools/farm/farm_folder.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "tools/farm/farm_record.h"
#include "tools/farm/job_queue.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/system/version.h"
#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

bool is_farm_or_run(const fs::path& folder) {
  return is_farm_folder(folder) || is_run_folder(folder);
}

// of several runs; of one, whose folder is also that run's
constexpr FolderKind farm_kind{"farm of umax", ".umax-farm", is_farm_folder},
    single_farm_kind{"farm of umax", ".umax-farm", is_farm_or_run};

/// Removes files of one kind from a folder that is ours, and the folder if nothing is left in it.
void remove_ours(const fs::path& folder, const std::string& ending) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (ending.empty() || entry->path().extension() == ending) files.push_back(entry->path());
  for (const fs::path& file : files) fs::remove(file, error);
  remove_if_empty(folder);
}

/// The folder of the one run, known as a run's: its jobs go on with it.
void make_run_folder(const fs::path& path, ExistingFolder existing, const FarmRun& run) {
  const RunFolder folder(path, existing);
  if (read_run_record(folder.record())) return;
  RunRecord record;
  record.version = version_text();
  record.verb = "farm";
  record.scene = run.title;
  record.scene_sha256 = sha256_hex(run.scene);
  record.host = host_description();
  record.exit_status = 75;
  record.ended = "before it began: its jobs wait in a queue";
  write_file(folder.scene(), run.scene);
  write_run_record(folder.record(), record);
}

[[noreturn]] void refuse(const fs::path& where, const std::string& what, const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where.string(), .what = what, .remedy = remedy});
}

/// Runs that are there are gone on with only as what they were.
void require_same_scenes(const FarmPlan& plan, const FarmPaths& paths) {
  std::error_code error;
  for (const FarmRun& run : plan.runs)
    if (const fs::path file = paths.scene(run.name); fs::exists(file, error) && read_file(file) != run.scene)
      refuse(file, "is another scene than the one that is to be made now",
             "choose another folder with -o, or replace it with --overwrite");
}

}  // namespace

FarmPaths farm_paths(const fs::path& folder, bool is_varied) {
  const fs::path full = fs::absolute(folder).lexically_normal();
  return {full.has_filename() ? full : full.parent_path(), is_varied};
}

bool is_farm_folder(const fs::path& folder) {
  return is_record_of(farm_paths(folder, false).record(), "umax farm");
}

void require_no_jobs(const fs::path& folder) {
  if (!is_farm_folder(folder)) return;
  const FarmPaths paths = farm_paths(folder, false);
  const FarmRecord record = read_farm_record(paths.record());
  const std::vector<QueuedTask> tasks = unfinished_tasks(record, read_file(paths.queue()));
  if (tasks.empty()) return;
  const auto job = std::find_if(record.jobs.begin(), record.jobs.end(),
                                [&](const SubmittedJob& other) { return other.id == tasks.front().job; });
  throw Error(Fault::try_again,
              {.where = folder.string(),
               .what = fmt::format("its job {} ({}) is in the queue still", job->name, job->id),
               .remedy = "wait until umax farm status says that none is, or end them by umax farm cancel"});
}

FarmPaths make_farm_folder(const FarmPlan& plan, const fs::path& folder, ExistingFolder existing) {
  const FarmPaths paths = farm_paths(folder, plan.is_varied);
  const bool overwrite = existing == ExistingFolder::overwrite;
  if (is_farm_folder(folder) && existing != ExistingFolder::refuse) {
    if (read_farm_record(paths.record()).is_varied != plan.is_varied)
      refuse(folder, plan.is_varied ? "is the farm of one run" : "is a farm of several runs",
             "choose another folder with -o");
    if (!overwrite) require_same_scenes(plan, paths);
  }
  if (!plan.is_varied) make_run_folder(paths.path, existing, plan.runs.front());
  const LockedFolder held(paths.path, plan.is_varied ? existing : ExistingFolder::keep,
                          plan.is_varied ? farm_kind : single_farm_kind);
  if (overwrite) {
    if (plan.is_varied) remove_runs(paths.path / "runs");
    remove_ours(paths.scenes(), ".toml");
    remove_ours(paths.logs(), ".log");
    remove_ours(paths.calls(), "");
  }
  for (const fs::path& place : {paths.farm(), paths.scenes(), paths.logs(), paths.calls()}) create_folder(place);
  for (const FarmRun& run : plan.runs) write_file(paths.scene(run.name), run.scene);
  return paths;
}

}  // namespace umax
