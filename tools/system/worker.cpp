#include "tools/system/worker.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/base/error.h"

namespace umax {
namespace {

struct Process {
  char state = 'X';
  long long start = 0;
};

/// What the kernel says of a process; none: there is no such one.
std::optional<Process> find_process(const std::string& number) {
  std::ifstream file("/proc/" + number + "/stat");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  // the name stands in brackets and may hold anything
  std::istringstream rest(line.substr(line.rfind(')') + 1));
  Process process;
  rest >> process.state;
  std::string word;
  for (int field = 4; field < 22; ++field) rest >> word;
  rest >> process.start;
  return rest ? std::optional(process) : std::nullopt;
}

double lease_wanted() {
  const char* text = std::getenv("UMAX_LEASE");
  if (!text) return Worker().lease;
  char* end = nullptr;
  const double seconds = std::strtod(text, &end);
  if (end != text && *end == '\0' && seconds >= 1 && seconds <= 86400) return seconds;
  throw Error(Fault::usage, {.where = "UMAX_LEASE",
                             .what = "must be seconds from 1 to 86400",
                             .value = "\"" + std::string(text) + "\"",
                             .remedy = "leave it out for 60"});
}

std::string first_line(const char* path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

bool is_on_this_machine(const Worker& worker, const Worker& self) {
  return !worker.boot.empty() && !worker.processes.empty() && worker.start > 0 && worker.host == self.host &&
         worker.boot == self.boot && worker.processes == self.processes;
}

}  // namespace

Worker this_worker(const std::string& role) {
  Worker worker;
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  worker.host = host.data();
  worker.boot = first_line("/proc/sys/kernel/random/boot_id");
  std::error_code error;
  worker.processes = std::filesystem::read_symlink("/proc/self/ns/pid", error).string();
  worker.process = ::getpid();
  if (const auto process = find_process("self")) worker.start = process->start;
  worker.lease = lease_wanted();
  worker.role = role;
  return worker;
}

std::string worker_text(const Worker& worker) {
  return fmt::format("host {}\nboot {}\nprocesses {}\nprocess {}\nstart {}\nlease {}\nrole {}\nend\n", worker.host,
                     worker.boot, worker.processes, worker.process, worker.start, worker.lease, worker.role);
}

std::optional<Worker> parse_worker(const std::string& text) {
  std::map<std::string, std::string> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.find(' ');
    values[line.substr(0, space)] = space == std::string::npos ? "" : line.substr(space + 1);
  }
  if (!values.count("end") || !values.count("host")) return std::nullopt;
  Worker worker;
  worker.host = values["host"];
  worker.boot = values["boot"];
  worker.processes = values["processes"];
  worker.process = std::atoll(values["process"].c_str());
  worker.start = std::atoll(values["start"].c_str());
  worker.lease = std::atof(values["lease"].c_str());
  worker.role = values["role"];
  return worker;
}

bool is_alive(const Worker& worker, double age) {
  static const Worker self = this_worker({});
  if (!is_on_this_machine(worker, self)) return age <= worker.lease;
  const auto process = find_process(std::to_string(worker.process));
  return process && process->start == worker.start && process->state != 'Z' && process->state != 'X';
}

std::string describe(const Worker& worker) {
  return fmt::format("process {} on {}", worker.process, worker.host);
}

}  // namespace umax
