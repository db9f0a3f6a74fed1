#include "tools/benchmarks/bench_against.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/system/scratch_folder.h"

namespace umax {
namespace {

using Row = std::map<std::string, double>;  // of steps.csv: column -> number

// Versions differ in their columns: those are found by name. What is no number, as the status, is left out.
std::vector<Row> steps_in(const std::filesystem::path& file) {
  std::istringstream lines(read_file(file));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all;
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) all.push_back(cell);
    return all;
  };
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = cells(line);
  std::vector<Row> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> texts = cells(line);
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(texts.size(), names.size()); ++i) {
      char* end = nullptr;
      const double value = std::strtod(texts[i].c_str(), &end);
      if (end != texts[i].c_str()) row[names[i]] = value;
    }
  }
  return rows;
}

double sum_of_time(const std::vector<Row>& steps, const std::function<bool(const Row&)>& counts, bool mean) {
  double sum = 0;
  int count = 0;
  for (const Row& step : steps)
    if (counts(step)) sum += step.at("wall_ms"), ++count;
  if (count == 0) throw std::runtime_error("no step of that kind");
  return mean ? sum / count : sum;
}

double active_step(const std::vector<Row>& steps) {
  return sum_of_time(
      steps, [](const Row& step) { return step.at("contacts") > 0 || step.at("limits_active") > 0; }, true);
}
double step_in_contact(const std::vector<Row>& steps) {
  return sum_of_time(steps, [](const Row& step) { return step.at("contacts") > 0; }, true);
}
double all_steps(const std::vector<Row>& steps) {
  return sum_of_time(steps, [](const Row&) { return true; }, false);
}

// a block that is clamped at one side, and thrown across itself so that most hexes come to their limits in the first step
constexpr const char* thrown_block = R"([clip]
frames = 2
fps = 60
gravity = [0, 0, 0]
[solver]
linear = "multigrid"
[body.block]
shape = "box"
size = [1, 1, 1]
position = [0, 1, 0]
velocity = [0, -12, 0]
cage.cells = [46, 46, 46]
limit.stretch = "20 %"
fixed = [{ min = [-0.6, 0, -1], max = [-0.49, 2, 1] }]
)";

struct Comparison {
  std::string name, what, scene;
  std::vector<std::string> words;
  double (*measure)(const std::vector<Row>&);  // [ms]
  double must = 1, aim = 1;                    // of the other program's time
  int turns = 3;
  bool is_long = false, needs_models = false;
};

std::vector<Comparison> comparisons() {
  const auto figure = [](const std::string& cells) {
    return std::vector<std::string>{"--set", "body.figure.cage.cells=" + cells};
  };
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const std::vector<std::string> second{"--frames", "1-61"};
  std::vector<Comparison> all;
  all.push_back({.name = "armadillo",
                 .what = "armadillo, 365 hexes: active step",
                 .scene = "armadillo",
                 .words = {"--set", "body.armadillo.mesh=" + model_path("armadillo.obj")},
                 .measure = active_step,
                 .must = 0.8,
                 .aim = 0.5,
                 .turns = 5,
                 .needs_models = true});
  all.push_back({.name = "figure",
                 .what = "figure, 365 hexes: active step",
                 .scene = "figure",
                 .words = second,
                 .measure = active_step,
                 .must = 1,
                 .aim = 0.5,
                 .turns = 5});
  all.push_back({.name = "figure-1k",
                 .what = "figure, 1,000 hexes: a second with its landing",
                 .scene = "figure",
                 .words = with(figure("1000"), second),
                 .measure = all_steps,
                 .must = 0.5,
                 .aim = 0.3});
  all.push_back({.name = "figure-2k",
                 .what = "figure, 2,000 hexes: a second with its landing",
                 .scene = "figure",
                 .words = with(figure("2000"), second),
                 .measure = all_steps,
                 .must = 0.65,
                 .aim = 0.45});
  all.push_back({.name = "figure-8k",
                 .what = "figure, 8,000 hexes: a second with its landing",
                 .scene = "figure",
                 .words = with(figure("8000"), second),
                 .measure = all_steps,
                 .must = 0.55,
                 .aim = 0.35});
  all.push_back({.name = "block-97k",
                 .what = "block of 97,336 hexes: the step from rest to its limits",
                 .scene = "block",
                 .words = {},
                 .measure = all_steps,
                 .must = 0.4,
                 .aim = 0.25});
  all.push_back({.name = "figure-100k",
                 .what = "figure, 100,000 hexes: mean of the steps in contact",
                 .scene = "figure",
                 .words = with(figure("100000"), {"--frames", "1-46"}),
                 .measure = step_in_contact,
                 .must = 0.43,
                 .aim = 0.2,
                 .turns = 1,
                 .is_long = true});
  all.push_back({.name = "figure-1m",
                 .what = "figure, 1,000,000 hexes: a second",
                 .scene = "figure",
                 .words = with(figure("1000000"), second),
                 .measure = all_steps,
                 .must = 0.48,
                 .aim = 0.24,
                 .turns = 1,
                 .is_long = true});
  return all;
}

double run_once(const std::string& program, const Comparison& comparison, const std::filesystem::path& folder) {
  std::filesystem::remove_all(folder / "run");
  const std::string scene = comparison.scene == "block" ? (folder / "block.toml").string() : comparison.scene;
  std::vector<std::string> command{program, "simulate", scene, "-o", (folder / "run").string(), "--quiet"};
  command.insert(command.end(), comparison.words.begin(), comparison.words.end());
  measure_command(command);
  return comparison.measure(steps_in(folder / "run/steps.csv"));
}

bool compare(const Comparison& comparison, const std::string& old_program) {
  const ScratchFolder scratch;
  write_file(scratch.path() / "block.toml", thrown_block);
  std::vector<double> now, before, ratios;
  for (int turn = 0; turn < comparison.turns; ++turn) {
    if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r{}: turn {} of {} ", comparison.name, turn + 1, comparison.turns);
    const bool old_first = turn % 2 == 1;
    if (old_first) before.push_back(run_once(old_program, comparison, scratch.path()));
    now.push_back(run_once(program(), comparison, scratch.path()));
    if (!old_first) before.push_back(run_once(old_program, comparison, scratch.path()));
    ratios.push_back(now.back() / before.back());
  }
  if (isatty(STDERR_FILENO)) fmt::print(stderr, "\r\x1b[K");
  const double ratio = median(ratios);
  const auto [least, largest] = std::minmax_element(ratios.begin(), ratios.end());
  fmt::print("{:<6} {:<58} {:<56} <= {:.2f} x (aim {:.2f})\n", ratio <= comparison.must ? "met" : "MISSED",
             comparison.what,
             fmt::format("{:.2f} x ({:.2f} to {:.2f}; {:.4g} and {:.4g} ms)", ratio, *least, *largest, median(now),
                         median(before)),
             comparison.must, comparison.aim);
  fmt::print("       [{}]\n", comparison.name);
  std::fflush(stdout);
  return ratio <= comparison.must;
}

}  // namespace

int bench_against(const AgainstOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.old_program, error))
    throw Error(Fault::not_found, {.where = "--against",
                                   .what = "there is no such program",
                                   .value = options.old_program,
                                   .remedy = "give the path of the other umax, as build/before/bin/umax"});
  int missed = 0, found = 0;
  for (Comparison comparison : comparisons()) {
    if (options.turns > 0) comparison.turns = options.turns;
    if (!options.only.empty() ? comparison.name != options.only : comparison.is_long && !options.full) continue;
    ++found;
    if (comparison.needs_models && model_path("").empty())
      fmt::print("       [{}: skipped, UMAX_MODELS names no folder]\n", comparison.name);
    else
      missed += !compare(comparison, std::filesystem::absolute(options.old_program).string());
  }
  if (found == 0)
    throw Error(Fault::not_found, {.where = "--only",
                                   .what = "there is no such row",
                                   .value = options.only,
                                   .remedy = "names stand in [brackets] below each row"});
  return missed;
}

}  // namespace umax
