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

}  // namespace umax
