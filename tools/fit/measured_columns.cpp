#include "tools/fit/measured_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "core/base/error.h"

namespace umax {
namespace {

enum class Role { deformation, load, lateral };

struct ColumnKind {
  Quantity quantity;
  Role role;
  Unit unit;
  std::set<std::string> names;
};

/// A name may stand for two kinds: the unit decides, and where there is none the first.
const std::vector<ColumnKind>& column_kinds() {
  static const std::vector<ColumnKind> kinds{
      {Quantity::stretch,
       Role::deformation,
       units::ratio,
       {"stretch", "strain", "shear", "shear strain", "nominal strain", "engineering strain", "eng strain",
        "tensile strain", "compressive strain", "axial strain", "elongation", "extension"}},
      {Quantity::stretch_ratio, Role::deformation, units::ratio, {"stretch ratio", "extension ratio", "lambda", "λ"}},
      {Quantity::displacement,
       Role::deformation,
       units::length,
       {"displacement", "extension", "elongation", "disp", "crosshead displacement", "travel"}},
      {Quantity::force, Role::load, units::force, {"force", "load", "axial force", "tensile force"}},
      {Quantity::stress,
       Role::load,
       units::pressure,
       {"stress", "nominal stress", "engineering stress", "eng stress", "tensile stress", "compressive stress",
        "shear stress", "axial stress"}},
      {Quantity::lateral_stretch,
       Role::lateral,
       units::ratio,
       {"lateral stretch", "lateral strain", "transverse stretch", "transverse strain"}},
      {Quantity::lateral_stretch_ratio,
       Role::lateral,
       units::ratio,
       {"lateral stretch ratio", "transverse stretch ratio"}}};
  return kinds;
}

struct Title {
  std::string name, unit;
};

[[noreturn]] void fail(const std::string& where, const std::string& what, const std::string& value,
                       const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where, .what = what, .value = value, .remedy = remedy});
}

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return text;
}

/// Small letters and single blanks.
std::string plain_name(const std::string& text) {
  std::string name;
  for (const char c : lower(text)) {
    const bool blank = c == '_' || c == ' ' || c == '-' || c == '.';
    if (!blank || (!name.empty() && name.back() != ' ')) name += blank ? ' ' : c;
  }
  while (!name.empty() && name.back() == ' ') name.pop_back();
  return name;
}

/// Units as tables write them, where the scene's own do not know them.
std::string known_unit(const std::string& text) {
  static const std::map<std::string, std::string> others{
      {"-", ""},        {"1", ""},        {"mm/mm", ""},   {"m/m", ""},      {"in/in", ""},    {"cm/cm", ""},
      {"pct", "%"},     {"percent", "%"}, {"perc", "%"},   {"mpa", "MPa"},   {"kpa", "kPa"},   {"gpa", "GPa"},
      {"pa", "Pa"},     {"n", "N"},       {"kn", "kN"},    {"newton", "N"},  {"n/mm2", "MPa"}, {"n/mm^2", "MPa"},
      {"n/mm²", "MPa"}, {"n/m2", "Pa"},   {"n/m^2", "Pa"}, {"kn/m2", "kPa"}, {"kn/m^2", "kPa"}};
  std::string problem;
  for (const Unit& unit : {units::ratio, units::length, units::force, units::pressure})
    if (parse_quantity("1 " + text, unit, problem)) return text;
  const auto found = others.find(lower(text));
  return found == others.end() ? text : found->second;
}

bool measures_something(const std::string& unit) {
  std::string problem;
  const std::array<Unit, 4> measured{units::ratio, units::length, units::force, units::pressure};
  return !unit.empty() && std::any_of(measured.begin(), measured.end(), [&](const Unit& wanted) {
    return parse_quantity("1 " + unit, wanted, problem).has_value();
  });
}

std::string without_blanks(std::string text) {
  std::erase(text, ' ');
  return text;
}

/// The kinds of column that a name may mean.
bool is_known(const std::string& name) {
  return std::any_of(column_kinds().begin(), column_kinds().end(),
                     [&](const ColumnKind& kind) { return kind.names.count(name) > 0; });
}

Title split_title(const std::string& title) {
  const std::size_t open = title.find_first_of("[("), close = title.find_last_of("])");
  if (open != title.npos) {
    const bool closed = close != title.npos && close > open;
    return {plain_name(title.substr(0, open)),
            closed ? known_unit(without_blanks(title.substr(open + 1, close - open - 1))) : ""};
  }
  // "stress / MPa", else the last word: "stress_MPa", "Force N"
  for (const char* between : {"/", "_ "}) {
    const std::size_t at = *between == '/' ? title.find('/') : title.find_last_of(between);
    if (at == title.npos) continue;
    const std::string name = plain_name(title.substr(0, at)), word = without_blanks(title.substr(at + 1));
    const std::string unit = known_unit(word);
    if (is_known(name) && (measures_something(unit) || (unit.empty() && !word.empty()))) return {name, unit};
  }
  return {plain_name(title), ""};
}

/// The kind that the name means and the unit fits; else the first that the name means, for the error.
const ColumnKind* kind_of(const Title& title) {
  const ColumnKind* first = nullptr;
  std::string problem;
  for (const ColumnKind& kind : column_kinds()) {
    if (kind.names.count(title.name) == 0) continue;
    if (!first) first = &kind;
    if (title.unit.empty() ? kind.unit.dimension == units::ratio.dimension
                           : parse_quantity("1 " + title.unit, kind.unit, problem).has_value())
      return &kind;
  }
  return first;
}

/// Throws unless the unit measures what the column holds.
void check_unit(const MeasuredColumn& column, const std::string& where) {
  const std::string remedy = fmt::format("write one of {} in brackets after its name", column.wanted.accepted);
  if (column.unit.empty()) {
    if (column.wanted.dimension != units::ratio.dimension) fail(where, "has no unit", column.title, remedy);
    return;
  }
  std::string problem;
  if (!parse_quantity("1 " + column.unit, column.wanted, problem))
    fail(where, problem.empty() ? "has a unit that cannot be read" : problem, column.title, remedy);
}

std::string meaning_of(Quantity quantity, bool shear) {
  switch (quantity) {
    case Quantity::stretch:
      return shear ? "displacement over height" : "change of length over length";
    case Quantity::stretch_ratio:
      return "length over length at rest";
    case Quantity::displacement:
      return shear ? "displacement" : "change of length";
    case Quantity::force:
      return "force";
    case Quantity::stress:
      return "force over the section at rest";
    case Quantity::lateral_stretch:
      return "change of width over width";
    case Quantity::lateral_stretch_ratio:
      return "width over width at rest";
  }
  return "";
}

std::string describe(const MeasuredColumn& column, bool shear) {
  const bool is_change = column.quantity == Quantity::stretch || column.quantity == Quantity::lateral_stretch;
  return fmt::format("\"{}\" as {}{}", column.title, meaning_of(column.quantity, shear),
                     !column.unit.empty() ? " in " + column.unit
                     : is_change          ? " (0.1 is 10 %)"
                                          : "");
}

/// A unit as a field of its own.
std::string unit_in(std::string field) {
  std::erase_if(field, [](char c) { return c == ' ' || c == '[' || c == ']' || c == '(' || c == ')'; });
  return known_unit(field);
}

bool holds_units(const CsvRow& row) {
  const auto begins_number = [](const std::string& field) {
    return !field.empty() && (std::isdigit(static_cast<unsigned char>(field[0])) || std::strchr("+.,", field[0]) ||
                              (field[0] == '-' && field.size() > 1));
  };
  return std::none_of(row.fields.begin(), row.fields.end(), begins_number) &&
         std::any_of(row.fields.begin(), row.fields.end(),
                     [](const std::string& field) { return measures_something(unit_in(field)); });
}

}  // namespace

int take_units(CsvTable& table, const std::string& name) {
  if (table.rows.empty() || !holds_units(table.rows.front())) return 0;
  const CsvRow row = std::move(table.rows.front());
  table.rows.erase(table.rows.begin());
  for (std::size_t i = 0; i < row.fields.size(); ++i) {
    const std::string unit = unit_in(row.fields[i]);
    std::string& title = table.header.fields[i];
    const std::string own = split_title(title).unit;
    if (own.empty() && !unit.empty())
      title += " [" + unit + "]";
    else if (!unit.empty() && own != unit)
      fail(fmt::format("{}:{}", name, row.line), "has another unit than the title above it",
           row.fields[i] + " below " + title, "leave one of them");
  }
  return row.line;
}

MeasuredColumns find_columns(const CsvRow& header, const std::string& name, std::vector<std::string>& warnings) {
  std::array<std::vector<MeasuredColumn>, 3> found;
  std::string ignored;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const Title title = split_title(header.fields[i]);
    if (const ColumnKind* kind = kind_of(title))
      found[std::size_t(kind->role)].push_back(
          {kind->quantity, kind->unit, i, header.fields[i], title.unit, title.name == "stretch" && title.unit.empty()});
    else
      ignored += (ignored.empty() ? "\"" : ", \"") + header.fields[i] + "\"";
  }
  const std::string where = fmt::format("{}:{}", name, header.line);
  constexpr std::array needs{"a column of stretch [%] or displacement [mm]", "a column of force [N] or stress [kPa]",
                             ""};
  for (const Role role : {Role::deformation, Role::load, Role::lateral}) {
    const std::vector<MeasuredColumn>& columns = found[std::size_t(role)];
    if (columns.empty() && role != Role::lateral)
      fail(where, "the header lacks " + std::string(needs[std::size_t(role)]), ignored,
           "name the columns as in stretch [%],force [N]; the first line that is no comment is the header");
    if (columns.size() > 1)
      fail(where, "two columns say the same", columns[0].title + " and " + columns[1].title, "leave one of them");
    for (const MeasuredColumn& column : columns) check_unit(column, where);
  }
  if (!ignored.empty()) warnings.push_back(fmt::format("{}: ignored what is in column {}", where, ignored));
  MeasuredColumns columns{found[0][0], found[1][0], std::nullopt};
  if (!found[2].empty()) columns.lateral = found[2][0];
  return columns;
}

std::string describe(const MeasuredColumns& columns, bool shear) {
  std::string text = describe(columns.deformation, shear) + ", " + describe(columns.load, shear);
  if (columns.lateral) text += ", " + describe(*columns.lateral, shear);
  return text;
}

}  // namespace umax
