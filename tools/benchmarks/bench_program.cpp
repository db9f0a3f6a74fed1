// Figures of the program as a whole: run from outside, in folders of its own, peak memory from the system's accounts.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "render/image/flip.h"
#include "render/image/image_io.h"
#include "tools/benchmarks/bench.h"
#include "tools/reproduce/experiments.h"
#include "tools/run/steps_csv.h"

namespace umax {
namespace {

struct Outcome {
  double seconds = 0;
  double peak_gib = 0;
  double cpu_seconds = 0;  // of it and of what it waited for
};

// a folder that goes with the benchmark
struct ScratchFolder {
  std::filesystem::path path;
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "umax-bench-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no scratch folder in " + name);
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

double cpu_seconds(const rusage& usage) {
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// runs a command with its output thrown away; throws if it fails
Outcome run(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  std::fflush(stdout);  // else the child would print what stands in the buffer, too
  const pid_t child = fork();
  if (child == 0) {
    if (!freopen("/dev/null", "w", stdout)) _exit(127);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) throw std::runtime_error("cannot run " + command[0]);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(fmt::format("{} ended with status {}", command[0], status));
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          double(usage.ru_maxrss) / (1024.0 * 1024.0), cpu_seconds(usage)};
}

std::string program() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "umax").string();
}

BenchRows demo() {
  const ScratchFolder scratch;
  const Outcome outcome = run({program(), "run", "figure", "-o", scratch.path / "demo", "--quiet"});
  return {at_most("figure: the demo's clip, 640x360", outcome.seconds / 60, 5, "min",
                  fmt::format("peak {:.2f} GiB", outcome.peak_gib))};
}

// the filtered frame against one with so many samples that filtering is idle
BenchRows noise() {
  const ScratchFolder scratch;
  run({program(), "simulate", "figure", "-o", scratch.path / "demo", "--frames", "1-60", "--quiet"});
  run({program(), "render", scratch.path / "demo", "--frames", "60", "-o", scratch.path / "few", "--quiet"});
  run({program(), "render", scratch.path / "demo", "--frames", "60", "-o", scratch.path / "many", "--samples", "1024",
       "--set", "render.denoise=false", "--quiet"});
  const Image8 few = read_png8(scratch.path / "few/frames/0060.png");
  const Image8 many = read_png8(scratch.path / "many/frames/0060.png");
  return {at_most("demo's frame 60 against 1024 samples: mean FLIP", flip(many, few).mean, 0.08, "")};
}

BenchRows armadillo_memory() {
  const ScratchFolder scratch;
  const Outcome outcome =
      run({program(), "run", "armadillo", "--set", "body.armadillo.mesh=" + model_path("armadillo.obj"), "--size",
           "1280x720", "--samples", "4", "--frames", "1-4", "-o", scratch.path / "clip", "--quiet"});
  return {at_most("armadillo clip at 1280x720: peak memory", outcome.peak_gib, 1, "GiB")};
}

BenchRows large_beam() {
  const ScratchFolder scratch;
  const Outcome outcome = run({program(), "simulate", "beam", "--set", "body.beam.cage.cells=[226,21,21]", "--set",
                               "body.beam.limit.kind=none", "--frames", "1-2", "-o", scratch.path / "beam", "--quiet"});
  return {at_most("beam, 99,666 hexes, no limits: peak memory", outcome.peak_gib, 8, "GiB",
                  fmt::format("one step and set-up in {:.0f} s", outcome.seconds))};
}

BenchRows ten_thousand() {
  const ScratchFolder scratch;
  const Outcome outcome = run({program(), "simulate", "figure", "--set", "body.figure.cage.cells=10000", "--frames",
                               "1-3", "-o", scratch.path / "figure", "--quiet"});
  return {at_most("figure, 10 k hexes: peak memory", outcome.peak_gib, 1, "GiB")};
}

// one second of clip with a cage of a million hexes, its landing in it; every step must converge
BenchRows million() {
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path / "figure";
  const Outcome outcome = run({program(), "simulate", "figure", "--set", "body.figure.cage.cells=1000000", "--frames",
                               "1-60", "--strict", "-o", folder, "--quiet"});
  const StepsFound steps = read_steps(folder / "steps.csv", steps_header({}));
  const auto most = [&](const char* column) {
    const std::vector<double>& values = steps.columns.at(column);
    return *std::max_element(values.begin(), values.end());
  };
  const std::string what = "figure, 1 M hexes, one second of clip";
  return {at_most(what, outcome.seconds / 60, 30, "min",
                  fmt::format("{} steps, the longest {:.0f} s, {:.0f} retries at most", steps.rows,
                              most("wall_ms") / 1e3, most("retries"))),
          at_most(what + ": peak memory", outcome.peak_gib, 4, "GiB"),
          at_most(what + ": max U/U_max", most("max_energy_ratio"), 1.001, "")};
}

std::vector<std::string> reproduce(const std::filesystem::path& report) {
  std::vector<std::string> command{program(), "reproduce", "--quiet", "-o", report};
  if (!model_path("").empty()) {
    command.push_back("--set");
    command.push_back("body.armadillo.mesh=" + model_path("armadillo.obj"));
  }
  return command;
}

BenchRows tuning() {
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path / "tune";
  const Outcome outcome =
      run({program(), "tune", "figure", "--vary", "body.figure.limit.stretch=2.5%,5%,7.5%,10%,15%,20%,30%,40%", "--set",
           "clip.frames=120", "-o", folder, "--quiet"});
  const double megabytes = double(std::filesystem::file_size(folder / "tune.html")) / 1e6;
  return {at_most("umax tune: 8 variants of figure, 120 frames, 320x180", outcome.seconds / 60, 3, "min",
                  fmt::format("{:.0f} s of processors", outcome.cpu_seconds)),
          at_most("its page", megabytes, 25, "MB")};
}

BenchRows quick_report() {
  const ScratchFolder scratch;
  std::vector<std::string> command = reproduce(scratch.path / "report");
  command.push_back("--quick");
  return {at_most("umax reproduce --quick: the paper's experiments", run(command).seconds / 60, 5, "min")};
}

// one experiment after the other into one report, as a user might
BenchRows whole_report() {
  const ScratchFolder scratch;
  BenchRows rows;
  double sum = 0, longest = 0;
  std::string slowest;
  for (const Experiment& experiment : experiments()) {
    std::vector<std::string> command = reproduce(scratch.path / "report");
    command.insert(command.begin() + 2, experiment.name);
    if (sum > 0) command.push_back("--resume");
    const double minutes = run(command).seconds / 60;
    sum += minutes;
    if (minutes > longest) slowest = experiment.name;
    longest = std::max(longest, minutes);
  }
  return {at_most("umax reproduce NAME: the longest", longest, 10, "min", slowest),
          at_most("umax reproduce, all names", sum, 40, "min")};
}

// a build from nothing; the source folder is told by tools/bench
BenchRows clean_build() {
  const char* source = std::getenv("UMAX_SOURCE");
  if (!source) throw std::runtime_error("run this one through tools/bench");
  const ScratchFolder scratch;
  run({"cmake", "-S", source, "-B", scratch.path, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
       "-DUMAX_ARCH=x86-64-v3"});
  const Outcome outcome = run({"cmake", "--build", scratch.path, "--parallel", "2"});
  return {at_most("clean build of everything, 2 jobs", outcome.seconds / 60, 6, "min")};
}

}  // namespace

std::vector<Benchmark> program_benchmarks() {
  return {
      {"memory", false, true, armadillo_memory},
      {"10k", false, false, ten_thousand},
      {"100k", false, false, large_beam},
      {"figure-1m", true, false, million},
      {"demo", false, false, demo},
      {"noise", true, false, noise},
      {"tune", false, false, tuning},
      {"reproduce-quick", false, false, quick_report},
      {"reproduce", true, false, whole_report},
      {"build", true, false, clean_build},
  };
}

}  // namespace umax
