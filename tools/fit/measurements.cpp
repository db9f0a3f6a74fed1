#include "tools/fit/measurements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "scenes/quantity.h"
#include "tools/fit/csv_table.h"
#include "tools/fit/measured_columns.h"

namespace umax {
namespace {

constexpr std::size_t fewest_points = 5;
constexpr std::size_t fewest_loads = 3;

[[noreturn]] void fail(const std::string& where, const std::string& what, const std::string& value,
                       const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where, .what = what, .value = value, .remedy = remedy});
}

bool is_missing(const std::string& field) {
  static const std::set<std::string> words{"", "-", "nan", "NaN", "NAN", "n/a", "N/A", "NA", "null"};
  return words.count(field) > 0;
}

/// The field in SI units; nothing where there is no number.
std::optional<double> read_field(const CsvRow& row, const MeasuredColumn& column, const std::string& name) {
  const std::string& field = row.fields[column.index];
  if (is_missing(field)) return std::nullopt;
  std::string problem;
  const auto quantity = parse_quantity(column.unit.empty() ? field : field + " " + column.unit, column.wanted, problem);
  if (!quantity)
    fail(fmt::format("{}:{}: {}", name, row.line, column.title), problem.empty() ? "is no number" : problem,
         "\"" + field + "\"", "write a number with a point, as in 12.5, or leave the field empty");
  return quantity->value;
}

/// Signs such that deformation and load are positive in tension or shear, negative in compression.
void orient(Measurements& measurements, bool ratio) {
  double stretch_sum = 0, stress_sum = 0;
  for (const MeasuredPoint& point : measurements.points) stretch_sum += point.stretch, stress_sum += point.stress;
  if (measurements.test == TestKind::uniaxial) return;
  const double wanted = measurements.test == TestKind::compression ? -1 : 1;
  const bool turn_stretch = !ratio && stretch_sum * wanted < 0, turn_stress = stress_sum * wanted < 0;
  for (MeasuredPoint& point : measurements.points) {
    if (turn_stretch) point.stretch = -point.stretch;
    if (turn_stress) point.stress = -point.stress;
  }
}

/// Whether numbers between which the title does not decide are lengths over the length at rest: above 1 in tension,
/// below in compression, and nearer to 1 than to 0 where the load is least.
bool looks_like_ratio(const Measurements& measurements) {
  if (measurements.test == TestKind::shear || measurements.points.empty()) return false;
  constexpr double noise = 0.02;
  double largest = 0;
  const MeasuredPoint* least = &measurements.points.front();
  for (const MeasuredPoint& point : measurements.points) {
    largest = std::max(largest, std::abs(point.stress));
    if (std::abs(point.stress) < std::abs(least->stress)) least = &point;
  }
  for (const MeasuredPoint& point : measurements.points) {
    if (std::abs(point.stress) <= noise * largest) continue;
    const bool in_tension = measurements.test == TestKind::uniaxial && point.stress > 0;
    if (in_tension ? point.stretch < 1 - noise : !(point.stretch > 0 && point.stretch < 1 + noise)) return false;
  }
  return std::abs(least->stretch - 1) < std::abs(least->stretch);
}

void check_rows(const Measurements& measurements, const MeasuredColumns& columns) {
  for (const MeasuredPoint& point : measurements.points) {
    const std::string where = fmt::format("{}:{}: ", measurements.name, point.line);
    if (point.stretch <= -1 && measurements.test != TestKind::shear)
      fail(where + columns.deformation.title, "leaves nothing of the length",
           fmt::format("a stretch of {:.4g} %", 100 * point.stretch),
           "a stretch is the change of length over length, above -100 %; ratios go in a column \"stretch ratio\"");
    if (point.lateral_stretch <= -1)
      fail(where + columns.lateral->title, "leaves nothing of the width",
           fmt::format("a stretch of {:.4g} %", 100 * point.lateral_stretch),
           "a lateral stretch is the change of width over width; ratios go in a column \"lateral stretch ratio\"");
  }
}

/// Unloaded, yet stretched to 1: ratios in a column of stretches.
void check_origin(const Measurements& measurements, const MeasuredColumns& columns) {
  if (columns.deformation.quantity != Quantity::stretch) return;
  double largest = 0;
  for (const MeasuredPoint& point : measurements.points) largest = std::max(largest, std::abs(point.stress));
  for (const MeasuredPoint& point : measurements.points)
    if (std::abs(point.stress) <= 0.02 * largest && std::abs(std::abs(point.stretch) - 1) < 0.05)
      fail(fmt::format("{}:{}: {}", measurements.name, point.line, columns.deformation.title),
           "is 1 where there is no force", fmt::format("{:g}", point.stretch),
           "lengths over the length at rest go in a column \"stretch ratio\"; a stretch is 0 at rest");
}

void check_enough(const Measurements& measurements, std::size_t num_rows) {
  const auto& points = measurements.points;
  if (points.size() < fewest_points)
    fail(measurements.name, fmt::format("needs at least {} rows with numbers", fewest_points),
         fmt::format("{} of {}", points.size(), num_rows), "measure at more forces");
  std::set<double> loads, stretches;
  double products = 0;
  for (const MeasuredPoint& point : points) {
    if (point.stress != 0) loads.insert(point.stress);
    stretches.insert(point.stretch);
    products += point.stress * point.stretch;
  }
  if (loads.size() < fewest_loads)
    fail(measurements.name, fmt::format("needs at least {} different forces other than zero", fewest_loads),
         std::to_string(loads.size()), "measure at more forces");
  if (stretches.size() < fewest_loads)
    fail(measurements.name, fmt::format("needs at least {} different stretches", fewest_loads),
         std::to_string(stretches.size()), "measure where the specimen still gives way");
  if (!(products > 0))
    fail(measurements.name, "has stretches that fall where forces rise", "",
         "forces and stretches are positive in tension, negative in compression; a test in compression with positive "
         "numbers takes --test compression");
}

double area_of(const MeasurementOptions& options, const MeasuredColumn& column, const std::string& name) {
  if (column.quantity == Quantity::stress) return 1;
  if (!options.area)
    throw Error(Fault::usage, {.where = name + ": " + column.title,
                               .what = "is a force, and says nothing of the material without the specimen's section",
                               .remedy = "give --area, as in --area \"25 mm^2\""});
  return *options.area;
}

double length_of(const MeasurementOptions& options, const MeasuredColumn& column, const std::string& name) {
  if (column.quantity != Quantity::displacement) return 1;
  if (!options.length)
    throw Error(Fault::usage, {.where = name + ": " + column.title,
                               .what = "says nothing of the material without the specimen's length",
                               .remedy = "give --length, as in --length \"50 mm\""});
  return *options.length;
}

/// "3 rows (lines 4, 7, 9)", of many the first.
std::string lines_text(const std::vector<int>& lines) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, lines.size()); ++i) text += (i ? ", " : "") + std::to_string(lines[i]);
  return fmt::format("{} (line{} {}{})", lines.size() == 1 ? "1 row" : fmt::format("{} rows", lines.size()),
                     lines.size() == 1 ? "" : "s", text, lines.size() > most ? ", …" : "");
}

/// How the table was read, where that is not as usual: "; separated by semicolons, decimal commas, units from line 2".
std::string layout_text(const CsvTable& table, bool decimal_commas, int units_line) {
  std::string text;
  if (table.separator != ',') text += table.separator == ';' ? "; separated by semicolons" : "; separated by tabs";
  if (decimal_commas) text += ", commas in numbers taken for decimal points";
  if (units_line > 0) text += fmt::format("{} units from line {}", text.empty() ? ";" : ",", units_line);
  return text;
}

}  // namespace

Measurements parse_measurements(std::string_view text, const std::string& name, const MeasurementOptions& options) {
  CsvTable table = parse_csv(text, name);
  const int units_line = take_units(table, name);
  const bool decimal_commas = take_decimal_commas(table);
  Measurements measurements{
      .name = name, .test = options.test, .points = {}, .has_lateral = false, .reading = {}, .warnings = {}};
  MeasuredColumns columns = find_columns(table.header, name, measurements.warnings);
  if (columns.lateral && options.test == TestKind::shear) {
    measurements.warnings.push_back(
        fmt::format("{}: ignored column \"{}\": a shear test has no width to speak of", name, columns.lateral->title));
    columns.lateral.reset();
  }
  const double area = area_of(options, columns.load, name), length = length_of(options, columns.deformation, name);
  const bool certain_ratio = columns.deformation.quantity == Quantity::stretch_ratio;
  std::vector<int> ignored;
  for (const CsvRow& row : table.rows) {
    const auto deformation = read_field(row, columns.deformation, name), load = read_field(row, columns.load, name);
    if (!deformation || !load) {
      ignored.push_back(row.line);
      continue;
    }
    MeasuredPoint point{
        .line = row.line, .stretch = *deformation / length - (certain_ratio ? 1 : 0), .stress = *load / area};
    if (columns.lateral)
      if (const auto lateral = read_field(row, *columns.lateral, name)) {
        point.lateral_stretch = *lateral - (columns.lateral->quantity == Quantity::lateral_stretch_ratio ? 1 : 0);
        measurements.has_lateral = true;
      }
    measurements.points.push_back(point);
  }
  if (!ignored.empty())
    measurements.warnings.push_back(
        fmt::format("{}: ignored {} without a number for stretch or force", name, lines_text(ignored)));
  const bool taken_for_ratio = columns.deformation.may_be_ratio && looks_like_ratio(measurements);
  if (taken_for_ratio) {
    columns.deformation.quantity = Quantity::stretch_ratio;
    for (MeasuredPoint& point : measurements.points) point.stretch -= 1;
  }
  measurements.reading =
      describe(columns, options.test == TestKind::shear) + layout_text(table, decimal_commas, units_line);
  orient(measurements, certain_ratio || taken_for_ratio);
  check_rows(measurements, columns);
  check_origin(measurements, columns);
  check_enough(measurements, table.rows.size());
  return measurements;
}

const char* test_name(TestKind test) {
  switch (test) {
    case TestKind::uniaxial:
      return "uniaxial";
    case TestKind::compression:
      return "compression";
    case TestKind::shear:
      return "shear";
  }
  return "unknown";
}

}  // namespace umax
