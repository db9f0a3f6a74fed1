// run.json: what made a run, how long it took, how it ended.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/system/worker.h"

namespace umax {

struct RunRecord {
  std::string version;  // of the program
  std::string verb;
  std::string scene;         // its name
  std::string scene_sha256;  // of scene.toml
  std::string model_sha256;  // of what decides the states (see model_digest)
  std::string host;
  int threads = 0;
  // by which steps were computed, with OpenBLAS's kernels; of calls by others, all in their order
  std::string instruction_set;
  std::string caller;   // "process 4711 on render07", of the last call
  std::string began;    // [UTC] when it did
  int frames = 0;       // states that are there
  long long steps = 0;  // time steps done
  long long steps_not_converged = 0;
  double simulate_seconds = 0, render_seconds = 0, encode_seconds = 0;  // [s] all calls together
  long long peak_memory = 0;                                            // [bytes] largest of all calls
  std::optional<int> exit_status;                                       // none: still running, or killed
  std::string ended;     // in words how the last call did; empty: still running, or killed
  int calls_killed = 0;  // that ended without a word, as the next one found
  double seconds() const { return simulate_seconds + render_seconds + encode_seconds; }
};

/// The file's text.
std::string run_record_text(const RunRecord& record);

/// Throws Error (cannot_create, io_error).
void write_run_record(const std::filesystem::path& path, const RunRecord& record);

/// The record at `path`; none when there is none, or when the file is not ours.
std::optional<RunRecord> read_run_record(const std::filesystem::path& path);

/// How a call ends that is killed.
inline constexpr const char* without_a_word = "without a word";

/// How the last call in the run's folder ended, in words: what its record says or, where that says nothing, whether its
/// process is among those who are at work there still.
std::string how_it_ended(const RunRecord& record, const std::vector<Worker>& at_work);

/// "name (processor, cores)".
std::string host_description();

/// [bytes] largest memory that this process has had.
long long peak_memory();

}  // namespace umax
