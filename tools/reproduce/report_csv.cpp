#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "tools/reproduce/report.h"

namespace umax {
namespace {

/// A field of a CSV file, quoted where it must be (RFC 4180).
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_rows(const std::string& section, const ReportTable& table) {
  std::string text;
  for (const ReportRow& row : table.rows) {
    assert(row.cells.size() == table.columns.size());
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      if (const auto& number = row.cells[i].number)
        text += fmt::format("{},{},{},{},{},{:.12g}\n", csv_field(section), csv_field(table.name), csv_field(row.name),
                            csv_field(table.columns[i].name), csv_field(table.columns[i].unit), *number);
  }
  return text;
}

}  // namespace

ReportCell number_cell(double number, int digits) {
  if (std::isnan(number)) return {.text = "–"};
  const bool is_long = std::abs(number) >= std::pow(10, digits) && std::abs(number) < 1e9;  // 2583, not 2.58e+03
  return {.text = is_long ? fmt::format("{:.0f}", number) : fmt::format("{:.{}g}", number, digits), .number = number};
}

std::string report_csv(const Report& report) {
  std::string text = "section,table,row,column,unit,value\n";
  for (const ReportSection& section : report.sections)
    for (const ReportBlock& block : section.blocks)
      if (const auto* table = std::get_if<ReportTable>(&block)) text += csv_rows(section.name, *table);
  return text;
}

}  // namespace umax
