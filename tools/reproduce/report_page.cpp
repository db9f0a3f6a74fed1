#include "core/files/read_file.h"
#include "tools/pages/html.h"
#include "tools/reproduce/report.h"

namespace umax {
namespace {

constexpr const char* style = R"(
body { background: #fff; color: #1d2026; font: 16px/1.55 sans-serif; margin: 0 auto; max-width: 76em; padding: 2em; }
h1, h2 { line-height: 1.2; }
h2 { border-top: 2px solid #d8dbe0; margin-top: 2.5em; padding-top: 1em; }
nav a { margin-right: 1.2em; }
figure { margin: 1.5em 0; }
figure img { max-width: 100%; height: auto; }
figcaption, caption { color: #4c525c; font-size: .93em; text-align: left; padding: .4em 0; }
table { border-collapse: collapse; margin: 1.2em 0; font-variant-numeric: tabular-nums; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid #d8dbe0; padding: .3em .9em; text-align: right; vertical-align: bottom; }
th:first-child, td:first-child, td.words { text-align: left; }
td:first-child { white-space: nowrap; }
td.words { min-width: 12em; }
caption { min-width: 34em; }
thead th { border-bottom: 2px solid #9aa1ac; }
.unit { color: #6a707b; font-weight: normal; }
.paper { border-left: 4px solid #3d73b9; padding: .2em 1em; background: #f0f5fb; }
.difference { border-left: 4px solid #c5701a; padding: .2em 1em; background: #fdf5ec; }
.paper::before { content: "The paper: "; font-weight: bold; }
.difference::before { content: "Where ours differs: "; font-weight: bold; }
)";

std::string block_html(const ReportText& text) {
  const char* kind = text.voice == ReportVoice::paper        ? " class=\"paper\""
                     : text.voice == ReportVoice::difference ? " class=\"difference\""
                                                             : "";
  return std::string("<p") + kind + ">" + html_text(text.text) + "</p>\n";
}

/// Words that need room, and start at the left.
bool is_sentence(const ReportCell& cell) {
  return !cell.number && cell.text.size() > 12;
}

std::string block_html(const ReportTable& table) {
  std::string html = "<table><caption>" + html_text(table.caption) + "</caption>\n<thead><tr><th></th>";
  for (const ReportColumn& column : table.columns) {
    html += "<th>" + html_text(column.name);
    if (!column.unit.empty()) html += " <span class=\"unit\">[" + html_text(column.unit) + "]</span>";
    html += "</th>";
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const ReportRow& row : table.rows) {
    html += "<tr><td>" + html_text(row.name) + "</td>";
    for (const ReportCell& cell : row.cells)
      html += (is_sentence(cell) ? "<td class=\"words\">" : "<td>") + html_text(cell.text) + "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string figure_html(const std::string& url, const std::string& caption) {
  return "<figure><img alt=\"" + html_text(caption) + "\" src=\"" + url + "\"><figcaption>" + html_text(caption) +
         "</figcaption></figure>\n";
}

std::string block_html(const ReportPicture& picture) {
  return figure_html(png_data_url(read_file(picture.png)), picture.caption);
}

std::string block_html(const ReportPlot& plot) {
  return figure_html(svg_data_url(draw_svg(plot.plot)), plot.caption);
}

std::string section_html(const ReportSection& section) {
  std::string html = "<section id=\"" + section.name + "\">\n<h2>" + html_text(section.title) + "</h2>\n";
  for (const ReportBlock& block : section.blocks)
    html += std::visit([](const auto& content) { return block_html(content); }, block);
  return html + "</section>\n";
}

}  // namespace

std::string report_page(const Report& report) {
  const std::string title = "Simulation of Hyperelastic Materials Using Energy Constraints, reproduced";
  std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + html_text(title) +
                     "</title><style>" + style + "</style></head><body>\n<h1>" + html_text(title) +
                     "</h1>\n<p>The experiments of Pérez, Pérez and Otaduy (CEIG 2013), run again by umax: what the "
                     "paper shows and says, and what comes out here, figure by figure and number by number. All "
                     "numbers are in report.csv beside this page; every run is a folder in runs, with its states and "
                     "steps.csv.</p>\n<p>" +
                     html_text(report.made_by) + "</p>\n<nav>";
  for (const ReportSection& section : report.sections)
    page += "<a href=\"#" + section.name + "\">" + html_text(section.name) + "</a>";
  page += "</nav>\n";
  for (const ReportSection& section : report.sections) page += section_html(section);
  return page + "</body></html>\n";
}

}  // namespace umax
