// umax_bench: prints every figure that the project promises, with its target, in one run.
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>

#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/bench_against.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/system/machine_memory.h"
#include "tools/system/threads.h"

namespace umax {

std::string model_path(const std::string& name) {
  const char* folder = std::getenv("UMAX_MODELS");
  return folder && *folder ? std::string(folder) + "/" + name : std::string();
}

BenchRow at_most(const std::string& what, double value, double limit, const std::string& unit,
                 const std::string& remark) {
  return {what, fmt::format("{:.4g} {}{}", value, unit, remark.empty() ? "" : ", " + remark),
          fmt::format("<= {:.4g} {}", limit, unit), value <= limit};
}

}  // namespace umax

namespace {

using namespace umax;

void print(const BenchRow& row) {
  fmt::print("{:<6} {:<62} {:<44} {}\n",
             row.target.empty() ? ""
             : row.met          ? "met"
                                : "MISSED",
             row.what, row.measured, row.target);
}

// one benchmark; a failure is a row, not the end of the others
int run(const Benchmark& benchmark) {
  const auto start = std::chrono::steady_clock::now();
  int missed = 0;
  try {
    for (const BenchRow& row : benchmark.run()) {
      print(row);
      missed += !row.met;
    }
  } catch (const std::exception& error) {
    print({benchmark.name, fmt::format("failed: {}", error.what()), "runs", false});
    ++missed;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("       [{}: {:.1f} s]\n", benchmark.name, seconds);
  std::fflush(stdout);
  return missed;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 2 && std::string(argv[1]) == "--measure") return measure_and_print(argv + 2);
  AgainstOptions against;
  std::string& only = against.only;
  bool& full = against.full;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--full") {
      full = true;
    } else if (argument == "--only" && i + 1 < argc) {
      only = argv[++i];
    } else if (argument == "--against" && i + 1 < argc) {
      against.old_program = argv[++i];
    } else if (argument == "--turns" && i + 1 < argc && std::atoi(argv[i + 1]) > 0) {
      against.turns = std::atoi(argv[++i]);
    } else {
      fmt::print(stderr,
                 "usage: tools/bench [--against OLD_UMAX [--turns N]] [--only NAME] [--full]; NAME is what stands in "
                 "[brackets] below "
                 "each group\n");
      return 2;
    }
  }
  if (!against.old_program.empty()) {
    try {
      fmt::print("{} figure(s) missed\n", bench_against(against));
      return 0;
    } catch (const std::exception& error) {
      fmt::print(stderr, "bench: error: {}\n", error.what());
      return 2;
    }
  }
  const umax::ThreadLimit all_cores(std::nullopt);
  std::vector<Benchmark> all = simulation_benchmarks();
  for (const std::vector<Benchmark>& more :
       {refinement_benchmarks(), multigrid_benchmarks(), large_cage_benchmarks(), penetration_benchmarks(),
        heap_benchmarks(), contact_benchmarks(), export_benchmarks(), import_benchmarks(), picture_benchmarks(),
        clip_benchmarks(), live_benchmarks(), aim_benchmarks(), python_benchmarks(), program_benchmarks()})
    all.insert(all.end(), more.begin(), more.end());

  keep_freed_memory();
  fmt::print("{} processors; figures are medians or means of one run on this machine\n", sysconf(_SC_NPROCESSORS_ONLN));
  int missed = 0, found = 0;
  for (const Benchmark& benchmark : all) {
    if (!only.empty() ? benchmark.name != only : benchmark.slow && !full) continue;
    ++found;
    if (benchmark.needs_models && model_path("").empty())
      fmt::print("       [{}: skipped, UMAX_MODELS names no folder]\n", benchmark.name);
    else
      missed += run(benchmark);
  }
  if (found == 0) {
    fmt::print(stderr, "bench: error: no benchmark called {}\n", only);
    return 2;
  }
  fmt::print("{} figure(s) missed\n", missed);
  return 0;
}
