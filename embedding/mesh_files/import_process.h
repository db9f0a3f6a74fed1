// One run of a helper program: started, waited for, ended when it takes too long. What it wrote lies in memory.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace umax {

struct ImportEnd {
  enum class Kind { exited, signalled, timed_out };
  Kind kind = Kind::exited;
  int number = 0;  // exit code or signal
};

class ImportProcess {
 public:
  /// Starts the command and waits until it closes its standard error, or for so many seconds by the clock. Meanwhile
  /// makes room for as many bytes of output as are likely. Throws Error (unavailable, io_error) where it cannot be
  /// started.
  ImportProcess(const std::vector<std::string>& command, long long seconds, long long likely_bytes);
  /// Ends it, with all that it started, if it still runs.
  ~ImportProcess();
  ImportProcess(const ImportProcess&) = delete;
  ImportProcess& operator=(const ImportProcess&) = delete;

  /// What it wrote to its standard output so far; lives as long as this.
  std::string_view output() const { return output_; }
  /// Waits for its end, no longer than the constructor would have, and then ends it.
  ImportEnd end();

 private:
  int child_ = -1;
  std::chrono::steady_clock::time_point deadline_;
  std::string_view output_;
};

}  // namespace umax
