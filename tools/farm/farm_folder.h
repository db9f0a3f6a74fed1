// The folder of a farm: the run or runs that it makes, and in DIR/farm its scripts, scenes, logs and record.
#pragma once

#include <filesystem>
#include <string>

#include "tools/farm/farm_plan.h"
#include "tools/system/locked_folder.h"

namespace umax {

/// Where things are in it; path: absolute.
struct FarmPaths {
  std::filesystem::path path;
  bool is_varied = false;  // see FarmPlan

  std::filesystem::path farm() const { return path / "farm"; }
  std::filesystem::path record() const { return farm() / "farm.json"; }
  std::filesystem::path queue() const { return farm() / "queue.sh"; }
  std::filesystem::path scenes() const { return farm() / "scenes"; }
  std::filesystem::path scene(const std::string& run) const { return scenes() / (run + ".toml"); }
  std::filesystem::path logs() const { return farm() / "logs"; }
  std::filesystem::path calls() const { return farm() / "calls"; }  // a file for each task: its calls of umax
  std::filesystem::path run(const std::string& name) const { return is_varied ? path / "runs" / name : path; }
};

FarmPaths farm_paths(const std::filesystem::path& folder, bool is_varied);

/// Whether the folder is a farm's.
bool is_farm_folder(const std::filesystem::path& folder);

/// Throws Error (try_again) while jobs of the farm in this folder, if there is one, are in its queue.
void require_no_jobs(const std::filesystem::path& folder);

/// Makes the farm's folder, or takes over one that is there: its runs, and folders for scripts, scenes, logs. overwrite:
/// removes what the runs had, and the logs. Throws Error: what LockedFolder and RunFolder throw; bad_data where it is
/// another scene's.
FarmPaths make_farm_folder(const FarmPlan& plan, const std::filesystem::path& folder, ExistingFolder existing);

}  // namespace umax
