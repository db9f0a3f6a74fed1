// Five named wants of umax aim on built-in scenes: how many runs each takes, and how near it comes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/files/read_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/system/scratch_folder.h"

namespace umax {
namespace {

struct NamedWant {
  const char *name, *scene, *want, *range;
};

constexpr NamedWant wants[] = {
    {"crouch", "figure", "height(figure) at 0.8 s = 85 %", "body.figure.limit.stretch=2%..60%"},
    {"sag", "beam", "min tip(tip, y) = -30 cm", "body.beam.material.young=50 kPa..2 MPa"},
    {"squash", "sphere", "min squash(sphere) = 70 %", "body.sphere.limit.energy=50 J..5 kJ"},
    {"collapse", "collapse", "min height(sphere) = 70 %", "body.sphere.limit.energy=5 J..500 J"},
    {"bounce", "limits", "bounce(c_no_limit) = 10 %", "body.c_no_limit.material.damping_stiffness=0..10 ms"},
};

constexpr int most_runs = 10;
constexpr double largest_error = 1;  // [%]

BenchRows rows_of(const NamedWant& want) {
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path() / "aim";
  const Measurement outcome = measure_command(
      {program(), "aim", want.scene, "--want", want.want, "--vary", want.range, "--quick", "--quiet", "-o", folder});
  const nlohmann::json record = nlohmann::json::parse(read_file(folder / "aim.json"));
  const auto& runs = record["runs"];
  const auto best =
      std::find_if(runs.begin(), runs.end(), [&](const auto& run) { return run["name"] == record["best"]; });
  if (best == runs.end()) throw std::runtime_error("aim.json names no best run");
  const std::string name = fmt::format("aim, {}: {}", want.name, want.want);
  return {at_most(name + ": runs", double(runs.size()), most_runs, "",
                  fmt::format("aim 6; {:.0f} s of processors", outcome.cpu_seconds)),
          at_most(name + ": error", 100 * std::abs((*best)["left"][0].get<double>()), largest_error, "%",
                  best->at("name").get<std::string>())};
}

BenchRows aim_rows() {
  BenchRows rows;
  for (const NamedWant& want : wants)
    for (const BenchRow& row : rows_of(want)) rows.push_back(row);
  return rows;
}

}  // namespace

std::vector<Benchmark> aim_benchmarks() {
  return {{.name = "aim", .run = aim_rows}};
}

}  // namespace umax
