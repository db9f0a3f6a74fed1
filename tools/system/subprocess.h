// Helper programs: found in PATH, started without a shell, fed and listened to.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace umax {

/// Where a program is; none if it is not in PATH.
std::optional<std::filesystem::path> find_program(const std::string& name);

struct ProcessResult {
  int exit_code = -1;    // 128 + n when a signal n ended it
  std::string output;    // what it wrote to its standard output
  std::string messages;  // and to its standard error
};

/// Gives the next piece of the helper's input; empty ends it.
using InputSource = std::function<std::string()>;

/// Runs a program to its end. Throws Error (unavailable) when it cannot be started. A helper that stops reading its
/// input is no error here: its exit code tells.
ProcessResult run_process(const std::vector<std::string>& command, const InputSource& input = {});

/// A program that runs beside us: what it writes to its standard output is read as it comes.
class RunningProcess {
 public:
  /// Throws Error (unavailable, io_error) when it cannot be started.
  explicit RunningProcess(const std::vector<std::string>& command);
  /// Ends it by SIGTERM if it still runs, and waits for it.
  ~RunningProcess();
  RunningProcess(const RunningProcess&) = delete;
  RunningProcess& operator=(const RunningProcess&) = delete;

  /// A file descriptor for poll(); -1 once the program has closed its output.
  int output() const { return output_; }
  /// Whole lines, without their ends, that have come since the last call. Does not wait.
  std::vector<std::string> new_lines();
  void send(int signal) const;
  /// Waits for its end; 128 + n when a signal n ended it.
  int wait();
  /// What it wrote to its standard error.
  std::string messages() const;

 private:
  int child_ = -1, output_ = -1, messages_ = -1;
  std::optional<int> exit_code_;
  std::string unfinished_;  // the beginning of a line
};

}  // namespace umax
