// Reads separated values (RFC 4180 and its kin): by commas, semicolons or tabs, quoted fields, any line ends, comment lines
// that begin with #.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace umax {

struct CsvRow {
  int line = 0;                       // of its first character, from 1
  std::vector<std::string> fields{};  // without quotes and outer spaces
};

struct CsvTable {
  CsvRow header{};
  std::vector<CsvRow> rows{};  // empty lines are left out
  char separator = ',';        // or ';', or '\t': what there is most of in the header
};

/// Throws Error (bad_data) that begins with `name`: no text, no header, a quote that never ends, a row that has fewer fields
/// than the header, or more that are not empty.
CsvTable parse_csv(std::string_view text, const std::string& name);

/// Where commas do not separate columns, "12,5" in a row becomes "12.5". Whether there was one.
bool take_decimal_commas(CsvTable& table);

}  // namespace umax
