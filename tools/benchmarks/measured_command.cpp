#include "tools/benchmarks/measured_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "tools/system/subprocess.h"

namespace umax {
namespace {

double cpu_seconds(const rusage& usage) {
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

std::string program() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "umax").string();
}

Measurement measure_command(const std::vector<std::string>& command) {
  std::vector<std::string> words{std::filesystem::read_symlink("/proc/self/exe").string(), "--measure"};
  words.insert(words.end(), command.begin(), command.end());
  const ProcessResult result = run_process(words);
  if (result.exit_code != 0)
    throw std::runtime_error(fmt::format("{} ended with code {}: {}", command.front(), result.exit_code,
                                         result.messages.substr(0, result.messages.find('\n'))));
  Measurement found;
  if (std::sscanf(result.output.c_str(), "%lf %lf %lf", &found.seconds, &found.cpu_seconds, &found.peak_bytes) != 3)
    throw std::runtime_error("no measurement of " + command.front());
  return found;
}

int measure_and_print(char* const* command) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    const int nowhere = ::open("/dev/null", O_WRONLY);
    if (nowhere < 0 || ::dup2(nowhere, STDOUT_FILENO) < 0) ::_exit(127);
    ::execvp(command[0], command);
    std::perror(command[0]);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child) return 127;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{:.6f} {:.6f} {}\n", seconds, cpu_seconds(usage), 1024LL * usage.ru_maxrss);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace umax
