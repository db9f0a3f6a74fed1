// How far a farm is: what is there of its runs, what its queue has left to do, what was lost on the way.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace umax {

struct FarmRunStatus {
  std::string name;
  int states = 0, pictures = 0;  // that are there
  bool has_clip = false;
};

struct FarmStatus {
  std::string name;
  int num_frames = 0;
  std::vector<FarmRunStatus> runs = {};
  std::map<std::string, int> tasks = {};  // in the queue, by their state
  std::string queue_problem = {};         // why the queue could not be asked; empty: it was
  int calls = 0;                          // of umax by jobs, so far
  int lost = 0;                           // of these that died, with their task or without, or could not write
  int recovered = 0;                      // of the lost ones, after which a later call of the same task ended well
  std::string command;                    // that made the farm
  bool is_whole() const;                  // all states, pictures and clips are there
};

/// Throws Error (not_found, bad_data) where there is no farm.
FarmStatus farm_status(const std::filesystem::path& folder);

/// For people.
std::string farm_status_text(const FarmStatus& status, const std::filesystem::path& folder);

/// For scripts: one JSON object.
std::string farm_status_json(const FarmStatus& status);

}  // namespace umax
