#include "tools/run/steps_csv.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/files/disk_error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"

namespace umax {
namespace {

constexpr const char* fixed_columns =
    "step,frame,time_s,status,hexes,limits_active,contacts,sqp_iterations,factorisations,linear_iterations,retries,"
    "max_energy_ratio,kkt_residual,max_penetration_m,kinetic_energy_J,elastic_energy_J,potential_energy_J,wall_ms";

// behind the probes, so that none of the columns before has moved since there were no others
constexpr const char* later_columns = ",contacts_obstacles,contacts_bodies,contacts_self,substeps";

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(Fault::io_error, {path.string(), what + " (" + std::strerror(errno) + ")", "", disk_remedy(errno)});
}

/// The first line of `text` without its end, which is taken off `text`; false when no whole line is left.
bool take_line(std::string_view& text, std::string_view& line) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return false;
  line = text.substr(0, end);
  text.remove_prefix(end + 1);
  return true;
}

std::string_view column(std::string_view line, int index) {
  for (; index > 0; --index) {
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) return {};
    line.remove_prefix(comma + 1);
  }
  return line.substr(0, line.find(','));
}

/// The text up to the first comma, which is taken off `line` with it.
std::string_view take_column(std::string_view& line) {
  const std::string_view text = line.substr(0, line.find(','));
  line.remove_prefix(std::min(line.size(), text.size() + 1));
  return text;
}

/// The number that stands there alone; NaN when none does.
double number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : std::nan("");
}

/// Bytes that header and the first `rows` rows take.
std::size_t length_of_rows(std::string_view text, long long rows) {
  std::string_view rest = text, line;
  for (long long i = 0; i <= rows; ++i)
    if (!take_line(rest, line)) break;
  return text.size() - rest.size();
}

}  // namespace

std::string steps_header(const std::vector<std::string>& probes) {
  std::string header = fixed_columns;
  for (const std::string& probe : probes)
    for (const char axis : {'x', 'y', 'z'}) header += fmt::format(",{}_{}_m", probe, axis);
  return header + later_columns;
}

const char* status_name(StepStatus status) {
  switch (status) {
    case StepStatus::converged:
      return "converged";
    case StepStatus::iteration_limit:
      return "iteration_limit";
    case StepStatus::infeasible:
      return "infeasible";
  }
  return "unknown";
}

std::string format_step(const StepRow& row) {
  const StepReport& r = row.report;
  std::string text =
      fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.3f}", row.step, row.frame, row.time,
                  status_name(r.status), row.hexes, r.limits_active, r.contacts, r.sqp_iterations, r.factorisations,
                  r.linear_iterations, r.retries, r.max_energy_ratio, r.kkt_residual, r.max_penetration,
                  r.kinetic_energy, r.elastic_energy, r.potential_energy, row.wall_ms);
  for (const Vector3d& probe : row.probes) text += fmt::format(",{},{},{}", probe.x(), probe.y(), probe.z());
  return text + fmt::format(",{},{},{},{}", r.contacts_obstacles, r.contacts_between, r.contacts_within, r.substeps);
}

StepsFound read_steps(const std::filesystem::path& path, const std::string& header) {
  StepsFound found;
  std::vector<std::vector<double>*> columns;
  for (std::string_view names = header; !names.empty();)
    columns.push_back(&found.columns[std::string(take_column(names))]);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return found;
  const std::string text = read_file(path);
  std::string_view rest = text, line;
  if (!take_line(rest, line)) return found;
  if (line != header)
    throw Error(Fault::bad_data, {path.string(), "has other columns than this run would write", "",
                                  "give the run another folder with -o, or replace it with --overwrite"});
  while (take_line(rest, line)) {
    const std::string_view number = column(line, 0);
    long long step = 0;
    std::from_chars(number.data(), number.data() + number.size(), step);
    if (step != found.rows + 1) break;
    ++found.rows;
    found.converged.push_back(column(line, 3) == "converged");
    for (std::vector<double>* values : columns) values->push_back(number_of(take_column(line)));
  }
  return found;
}

StepsFile::StepsFile(const std::filesystem::path& path, const std::string& header, long long rows) : path_(path) {
  std::error_code error;
  std::string text = header + "\n";
  if (rows > 0 && std::filesystem::exists(path, error)) {
    text = read_file(path);
    text.resize(length_of_rows(text, rows));
  }
  write_file(path, text);
  file_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file_ < 0) fail(path_, "cannot be opened");
}

StepsFile::~StepsFile() {
  if (file_ >= 0) ::close(file_);
}

void StepsFile::append(const std::vector<StepRow>& rows) {
  std::string text;
  for (const StepRow& row : rows) text += format_step(row) + "\n";
  const off_t before = ::lseek(file_, 0, SEEK_END);
  std::string_view rest = text;
  while (!rest.empty()) {
    const ssize_t written = ::write(file_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) break;
    rest.remove_prefix(std::size_t(written));
  }
  if (rest.empty() && ::fdatasync(file_) == 0) return;

  // half a group of rows is worse than none
  const int reason = errno;
  if (::ftruncate(file_, before) != 0) errno = reason;
  errno = reason;
  fail(path_, "cannot be written");
}

}  // namespace umax
