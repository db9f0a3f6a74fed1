// A command run and measured from a process of its own. The system counts a child's peak memory from what its parent
// holds when the child begins: the bench, which holds much, would measure itself.
#pragma once

#include <string>
#include <vector>

namespace umax {

struct Measurement {
  double seconds = 0;      // [s] wall clock
  double cpu_seconds = 0;  // [s] of it and of what it waited for
  double peak_bytes = 0;   // [bytes] largest resident memory
};

/// The program umax that stands beside the bench.
std::string program();

/// Runs a command with its output thrown away, as a child of `umax_bench --measure`. Throws std::runtime_error if it
/// fails.
Measurement measure_command(const std::vector<std::string>& command);

/// What `umax_bench --measure COMMAND...` does: runs the command and prints "SECONDS CPU_SECONDS PEAK_BYTES". `command`
/// ends with a null pointer. Returns the exit code: the command's, or 128 + n when signal n ended it.
int measure_and_print(char* const* command);

}  // namespace umax
