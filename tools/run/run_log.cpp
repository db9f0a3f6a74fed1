#include "tools/run/run_log.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <ctime>
#include <fstream>
#include <iterator>
#include <numeric>

#include "core/base/median.h"
#include "tools/system/worker.h"

namespace umax {
namespace {

/// A warning without its numbers: what of the same kind has in common.
std::string kind_of(const std::string& warning) {
  std::string kind;
  for (const char letter : warning) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(letter)) != 0;
    if (!is_digit)
      kind += letter;
    else if (kind.empty() || kind.back() != '#')
      kind += '#';
  }
  return kind;
}

/// What makes a step slow, in the order in which it is told.
struct Cause {
  const char* column;
  const char* name;
};
constexpr Cause causes[]{{"sqp_iterations", "iterations"},
                         {"retries", "halvings"},
                         {"substeps", "parts of the step"},
                         {"factorisations", "factorisations"},
                         {"linear_iterations", "sweeps and linear iterations"},
                         {"contacts", "contacts"},
                         {"limits_active", "active limits"}};

/// What the row has half as much again of as the median of the rows has.
std::string unusual(const StepsFound& steps, std::size_t row, const std::vector<double>& medians) {
  std::string text;
  for (std::size_t i = 0; i < std::size(causes); ++i) {
    const double value = steps.columns.at(causes[i].column)[row];
    if (value < 1.5 * medians[i] || value < medians[i] + 1) continue;
    text += fmt::format("{}{} {} (median {})", text.empty() ? "" : ", ", causes[i].name, value, medians[i]);
  }
  return text;
}

}  // namespace

RunLog::RunLog(Progress& progress) : progress_(progress) {
  const Worker self = this_worker("log");
  writer_ = fmt::format("{}:{}", self.host, self.process);
  progress_.set_witness({.note = [this](const std::string& text) { write(text); },
                         .warning =
                             [this](const std::string& text) {
                               write("warning: " + text);
                               const std::string kind = kind_of(text);
                               ++warnings_[kind];
                               first_of_kind_.emplace(kind, text);
                             }});
}

RunLog::~RunLog() {
  progress_.set_witness({});
  if (file_ < 0) return;
  fsync(file_);
  close(file_);
}

void RunLog::open(const std::filesystem::path& path) {
  file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  for (const std::string& line : kept_) append(line);
  kept_.clear();
}

void RunLog::write(const std::string& line) {
  if (file_ < 0)
    kept_.push_back(stamped(line));
  else
    append(stamped(line));
}

void RunLog::append(const std::string& text) const {
  // in one piece, so that the lines of several do not mix
  [[maybe_unused]] const ssize_t written = ::write(file_, text.data(), text.size());
}

std::string RunLog::stamped(const std::string& line) const {
  std::string text = fmt::format("{} {} {}", utc_time(), writer_, line);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text + '\n';
}

void RunLog::write_warnings() {
  if (warnings_.empty()) return;
  const int total = std::accumulate(warnings_.begin(), warnings_.end(), 0,
                                    [](int sum, const auto& kind) { return sum + kind.second; });
  write(fmt::format("warnings: {}", total));
  for (const auto& [kind, count] : warnings_) write(fmt::format("  {} x {}", count, first_of_kind_.at(kind)));
}

std::string utc_time() {
  return fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)));
}

std::string command_text() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  while (!text.empty() && text.back() == '\0') text.pop_back();
  std::replace(text.begin(), text.end(), '\0', ' ');
  return text;
}

std::vector<std::string> slowest_steps(const StepsFound& steps, long long first, int count) {
  const std::size_t begin = std::size_t(std::clamp(first, 0LL, steps.rows)), end = std::size_t(steps.rows);
  if (begin == end) return {};
  const auto of_call = [&](const char* column) {
    const std::vector<double>& all = steps.columns.at(column);
    return std::vector<double>(all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(end));
  };
  std::vector<double> medians;
  for (const Cause& cause : causes) medians.push_back(median(of_call(cause.column)));
  const std::vector<double>& times = steps.columns.at("wall_ms");
  const double usual = median(of_call("wall_ms"));

  std::vector<std::size_t> rows(end - begin);
  std::iota(rows.begin(), rows.end(), begin);
  const auto slowest_end = rows.begin() + std::min(std::ptrdiff_t(count), std::ptrdiff_t(rows.size()));
  std::partial_sort(rows.begin(), slowest_end, rows.end(),
                    [&](std::size_t a, std::size_t b) { return times[a] != times[b] ? times[a] > times[b] : a < b; });
  std::vector<std::string> lines{fmt::format("slowest of {} steps (median {:.3g} ms):", rows.size(), usual)};
  for (auto row = rows.begin(); row != slowest_end; ++row) {
    std::string cause = unusual(steps, *row, medians);
    if (*row == begin) cause += std::string(cause.empty() ? "" : ", ") + "the first of this call, which sets up";
    lines.push_back(fmt::format(
        "  step {:.0f} (frame {:.0f}, {:.4g} s): {:.3g} ms; {}{}", steps.columns.at("step")[*row],
        steps.columns.at("frame")[*row], steps.columns.at("time_s")[*row], times[*row],
        cause.empty() ? "nothing in it stands out" : cause, steps.converged[*row] ? "" : "; did not converge"));
  }
  return lines;
}

}  // namespace umax
