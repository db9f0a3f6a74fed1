// Rows of tools/bench: one measured figure each, beside what was asked for.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace umax {

struct BenchRow {
  std::string what;      // "armadillo, exact: active-step mean"
  std::string measured;  // "3.1 ms"
  std::string target;    // "<= 15 ms (aim 5)"; empty: told for the reader
  bool met = true;
};

using BenchRows = std::vector<BenchRow>;

/// A group of rows that one set-up yields; `--only NAME` runs it alone.
struct Benchmark {
  std::string name;
  bool slow = false;          // runs with --full, or when named
  bool needs_models = false;  // skipped with a line unless UMAX_MODELS names a folder
  std::function<BenchRows()> run;
};

std::vector<Benchmark> aim_benchmarks();          // bench_aim.cpp: wants of umax aim
std::vector<Benchmark> simulation_benchmarks();   // bench_simulation.cpp
std::vector<Benchmark> heap_benchmarks();         // bench_heap.cpp: contact between bodies
std::vector<Benchmark> contact_benchmarks();      // bench_contact.cpp
std::vector<Benchmark> refinement_benchmarks();   // bench_refinement.cpp: limits on finer cages
std::vector<Benchmark> multigrid_benchmarks();    // bench_multigrid.cpp
std::vector<Benchmark> large_cage_benchmarks();   // bench_large_cages.cpp
std::vector<Benchmark> program_benchmarks();      // bench_program.cpp: the built program, from outside
std::vector<Benchmark> penetration_benchmarks();  // bench_penetration.cpp
std::vector<Benchmark> export_benchmarks();       // bench_export.cpp
std::vector<Benchmark> import_benchmarks();       // bench_import.cpp: meshes read by the helper program
std::vector<Benchmark> live_benchmarks();         // bench_live.cpp: with a client
std::vector<Benchmark> picture_benchmarks();      // bench_pictures.cpp
std::vector<Benchmark> python_benchmarks();       // bench_python.cpp: the Python module
std::vector<Benchmark> clip_benchmarks();         // bench_clip.cpp: the demo as pictures

/// The file in UMAX_MODELS.
std::string model_path(const std::string& name);

/// Row whose value must not exceed the limit.
BenchRow at_most(const std::string& what, double value, double limit, const std::string& unit,
                 const std::string& remark = "");

}  // namespace umax
