// Which columns of a laboratory's table hold what, by the names and units that are usual in their titles.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/quantity.h"
#include "tools/fit/csv_table.h"

namespace umax {

enum class Quantity { stretch, stretch_ratio, displacement, force, stress, lateral_stretch, lateral_stretch_ratio };

struct MeasuredColumn {
  Quantity quantity = Quantity::stretch;
  Unit wanted;                // what its numbers measure
  std::size_t index = 0;      // in a row
  std::string title;          // as the file has it
  std::string unit;           // as parse_quantity() takes it; "" for none
  bool may_be_ratio = false;  // "stretch" without a unit: mechanics means length over length, many tables the change
};

struct MeasuredColumns {
  MeasuredColumn deformation, load;
  std::optional<MeasuredColumn> lateral;
};

/// Where the first row holds units instead of numbers ("mm", "[N]"), each goes into the title above it that has none, and
/// the row goes. Its line; 0: there is none. Throws Error (bad_data) naming the line where title and row say different ones.
int take_units(CsvTable& table, const std::string& name);

/// Units stand in brackets, behind a slash, or as the last word: "Force [N]", "stress / MPa", "stress_MPa". Other
/// columns are warned of. Throws Error (bad_data) naming the file's line: no column of deformation or load, two of one
/// kind, a unit that is missing or does not fit.
MeasuredColumns find_columns(const CsvRow& header, const std::string& name, std::vector<std::string>& warnings);

/// "\"strain\" as change of length over length (0.1 is 10 %), \"stress_MPa\" as force over the section at rest in MPa"
std::string describe(const MeasuredColumns& columns, bool shear);

}  // namespace umax
