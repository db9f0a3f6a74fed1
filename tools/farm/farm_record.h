// farm.json: what a farm makes, and by which jobs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/farm/job_queue.h"

namespace umax {

struct SubmittedJob {
  std::string name, id;
  int tasks = 1;
};

struct FarmRecord {
  std::string version;  // of the program
  std::string command;  // that made it
  std::string name;     // of the scene
  bool is_varied = false;
  int num_frames = 0, frames_per_job = 0;
  std::vector<std::string> runs;   // their names
  std::vector<SubmittedJob> jobs;  // of the last submission
};

/// Throws Error (cannot_create, io_error).
void write_farm_record(const std::filesystem::path& file, const FarmRecord& record);

/// Throws Error: not_found when there is none, bad_data when it is no farm's.
FarmRecord read_farm_record(const std::filesystem::path& file);

/// The farm's own tasks among those of the queue. Throws Error (unavailable).
std::vector<QueuedTask> unfinished_tasks(const FarmRecord& record, const QueueFunctions& queue);

}  // namespace umax
