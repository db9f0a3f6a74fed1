// run.json: what made a run, how long it took, how it ended.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace umax {

struct RunRecord {
  std::string version;  // of the program
  std::string verb;
  std::string scene;         // its name
  std::string scene_sha256;  // of scene.toml
  std::string model_sha256;  // of what decides the states (see model_digest)
  std::string host;
  int threads = 0;
  int frames = 0;       // states that are there
  long long steps = 0;  // time steps done
  long long steps_not_converged = 0;
  double simulate_seconds = 0, render_seconds = 0, encode_seconds = 0;  // [s] all calls together
  long long peak_memory = 0;                                            // [bytes] largest of all calls
  std::optional<int> exit_status;                                       // none: still running, or killed
  double seconds() const { return simulate_seconds + render_seconds + encode_seconds; }
};

/// Throws Error (cannot_create, io_error).
void write_run_record(const std::filesystem::path& path, const RunRecord& record);

/// The record at `path`; none when there is none, or when the file is not ours.
std::optional<RunRecord> read_run_record(const std::filesystem::path& path);

/// "name (processor, cores)".
std::string host_description();

/// [bytes] largest memory that this process has had.
long long peak_memory();

}  // namespace umax
