// One run of a helper program: started, waited for, ended when it takes too long; what it wrote lies in memory.
#pragma once

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
  /// Runs the command to its end, or for so many seconds by the clock. Throws Error (unavailable, io_error) where it
  /// cannot be started.
  ImportProcess(const std::vector<std::string>& command, long long seconds);
  ~ImportProcess();
  ImportProcess(const ImportProcess&) = delete;
  ImportProcess& operator=(const ImportProcess&) = delete;

  const ImportEnd& end() const { return end_; }
  /// What it wrote to its standard output; lives as long as this.
  std::string_view output() const { return output_; }

 private:
  ImportEnd end_;
  std::string_view output_;
};

}  // namespace umax
