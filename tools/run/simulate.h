// The frame loop: from the last whole state on, one state and its rows of steps.csv per frame.
#pragma once

#include "tools/run/run_folder.h"
#include "tools/setup/simulation_setup.h"
#include "tools/system/progress.h"

namespace umax {

struct SimulateOptions {
  int last_frame = 0;    // states 1 .. last_frame shall be there
  bool strict = false;   // a step that does not converge ends the run: Error (try_again)
  bool verbose = false;  // a line per iteration
};

struct SimulateResult {
  int frames = 0;                     // states that are there
  long long steps = 0;                // time steps that led to them, earlier calls included
  long long steps_not_converged = 0;  // of these
  int signal = 0;                     // that stopped it early; 0: none
};

/// Simulates up to options.last_frame. What is in the folder already is kept: a damaged state is said and computed
/// again from the one before. The states are the same to the last bit however often the run was broken off. Throws
/// Error: bad_data for states of another scene, try_again with `strict`, io_error when a file cannot be written.
SimulateResult simulate(const Simulation& simulation, const RunFolder& folder, const SimulateOptions& options,
                        Progress& progress);

}  // namespace umax
