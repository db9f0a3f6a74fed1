// Reads comma-separated values (RFC 4180): quoted fields, any line ends, comment lines that begin with #.
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
};

/// Throws Error (bad_data) that begins with `name`: no text, no header, semicolons for commas, a quote that never ends,
/// a row that has more or fewer fields than the header.
CsvTable parse_csv(std::string_view text, const std::string& name);

}  // namespace umax
