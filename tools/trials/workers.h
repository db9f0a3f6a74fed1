// Runs of this program beside each other, each in a process of its own: one that fails or dies takes no other with it.
#pragma once

#include <string>
#include <vector>

#include "tools/system/progress.h"

namespace umax {

struct WorkItem {
  std::string name;                 // for messages
  std::vector<std::string> words;   // the verb and its options
  int frames = 0, frames_done = 0;  // that it reports in all, and that are there already
  long long memory = 0;             // [bytes] that it may need
};

struct WorkResult {
  int exit_code = 0;    // 128 + n: ended by signal n
  std::string message;  // what went wrong, from its last line of error
};

struct WorkerOptions {
  int threads = 1;                             // of all workers together
  long long memory = 0;                        // [bytes] for all workers together
  std::string program = "/proc/self/exe";      // that is run
  std::vector<std::string> common_words = {};  // options that all get
};

/// How many of the items may run at once: no more than threads, and so that their memory fits; at least one.
int count_workers(const std::vector<WorkItem>& items, const WorkerOptions& options);

/// Runs all items, at most count_workers() at a time, and tells their frames as one stage. When a signal asks us to
/// stop, it is passed on, and no item is begun; results of items that were not begun have the signal's exit code.
/// Warnings of the items are told once each.
std::vector<WorkResult> run_workers(const std::vector<WorkItem>& items, const WorkerOptions& options,
                                    const std::string& stage, Progress& progress);

}  // namespace umax
