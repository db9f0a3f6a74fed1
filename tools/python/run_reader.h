// A run's folder as a script reads it: its scene set up again, and the states of its frames.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/python/body_values.h"

namespace umax {

struct RunReader {
  std::filesystem::path folder;
  Simulation simulation;
};

/// One frame of a run, which it keeps.
struct RunFrame {
  std::shared_ptr<RunReader> run;
  int number = 0;  // from 1
  State state;
};

/// Throws Error (not_found, bad_data) for a folder that is no run's, or whose meshes have changed.
std::shared_ptr<RunReader> open_run(const std::filesystem::path& folder);

/// Frames whose states are there, from 1 up to the first gap, now.
int num_frames(const RunReader& run);

/// Throws Error (not_found) where there is no such frame.
RunFrame read_frame(const std::shared_ptr<RunReader>& run, int number);

/// The columns of steps.csv that are numbers, by their names; one row a step.
std::map<std::string, std::vector<double>> step_columns(const RunReader& run);

}  // namespace umax
