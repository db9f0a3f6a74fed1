// What the report says, before it becomes a page and a table of numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tools/pictures/plot.h"

namespace umax {

/// A place in a table: a number as it is shown, or words.
struct ReportCell {
  std::string text;
  std::optional<double> number{};  // goes into report.csv
};

/// `digits` significant ones are shown; report.csv has all. NaN: "–", and not in report.csv.
ReportCell number_cell(double number, int digits = 3);

struct ReportColumn {
  std::string name;
  std::string unit{};  // empty: a pure number or words
};

struct ReportRow {
  std::string name;
  std::vector<ReportCell> cells;  // one a column
};

struct ReportTable {
  std::string name;     // in report.csv, unique in its section
  std::string caption;  // above it
  std::vector<ReportColumn> columns;
  std::vector<ReportRow> rows;
};

struct ReportPicture {
  std::filesystem::path png;
  std::string caption;
};

struct ReportPlot {
  Plot plot;
  std::string caption;
};

enum class ReportVoice {
  plain,
  paper,       // what the paper says
  difference,  // where ours differs from it, and why
};
struct ReportText {
  std::string text;
  ReportVoice voice = ReportVoice::plain;
};

using ReportBlock = std::variant<ReportText, ReportTable, ReportPicture, ReportPlot>;

struct ReportSection {
  std::string name;   // "figure3"
  std::string title;  // "Figure 3: the beam"
  std::vector<ReportBlock> blocks;
};

struct Report {
  std::string made_by;  // program and machine, one line
  std::vector<ReportSection> sections;
};

/// One HTML file that needs no other and no network: pictures and plots are inside. Throws Error (not_found, io_error)
/// when a picture cannot be read.
std::string report_page(const Report& report);

/// All numbers of all tables: section,table,row,column,unit,value.
std::string report_csv(const Report& report);

}  // namespace umax
