#include "tools/aim/aim_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/files/read_file.h"
#include "tools/aim/verdict.h"
#include "tools/pages/html.h"
#include "tools/run/run_record.h"
#include "tools/system/version.h"

namespace umax {

// Written by CMake into the build folder from page.html, page.css, page.js.
extern const std::pair<const char*, const char*> embedded_aim_page[];

namespace {

std::string embedded(const std::string& name) {
  for (std::size_t i = 0;; ++i)
    if (name == embedded_aim_page[i].first) return embedded_aim_page[i].second;
}

std::string cell(const std::string& text, const char* kind = "") {
  return fmt::format("<td{}>{}</td>", kind, html_text(text));
}

std::string head_row(const AimPlan& plan) {
  std::string row = "<tr><th>#</th>";
  for (const KeyRange& range : plan.keys) row += "<th>" + html_text(range.short_key) + "</th>";
  for (const Want& want : plan.wants) row += "<th>" + html_text(want.name) + "</th><th>left</th>";
  return row + "<th>steps not converged</th></tr>";
}

std::string run_row(const AimPlan& plan, const AimRun& run, std::size_t index, bool is_best) {
  std::string row = fmt::format("<tr{}>", is_best ? " class=\"best\"" : "") + cell(std::to_string(index + 1));
  for (std::size_t k = 0; k < plan.keys.size(); ++k) {
    const KeyRange& range = plan.keys[k];
    row += cell(!run.is_before() ? run.values[k]
                : range.own      ? value_text(range, *range.own) + ", as it is"
                                 : "as it is");
  }
  for (std::size_t w = 0; w < plan.wants.size(); ++w)
    row += cell(value_text(plan.wants[w], run.readings[w].value)) +
           cell(fmt::format("{:+.2f} %", 100 * run.miss[Eigen::Index(w)]));
  return row + cell(std::to_string(run.steps_not_converged), run.steps_not_converged > 0 ? " class=\"bad\"" : "") +
         "</tr>";
}

std::string rows_of(const AimPlan& plan, const AimRuns& runs, const AimRun& best) {
  std::string rows;
  for (std::size_t i = 0; i < runs.all().size(); ++i)
    rows += run_row(plan, runs.all()[i], i, &runs.all()[i] == &best) + "\n";
  return rows;
}

std::string plots_of(const AimPlan& plan, const AimFolder& folder) {
  std::string plots;
  for (const KeyRange& range : plan.keys)
    plots += fmt::format("<img src=\"{}\" alt=\"{}\">\n", svg_data_url(read_file(folder.plot(range.short_key))),
                         html_text("What is wanted against " + range.key + ", one point a run"));
  return plots;
}

std::string title_of(const AimPlan& plan) {
  std::vector<std::string> wants;
  for (const Want& want : plan.wants) wants.push_back(want.text);
  return plan.scene.name + ": " + fmt::format("{}", fmt::join(wants, ", "));
}

std::string summary_of(const AimPlan& plan) {
  std::vector<std::string> texts;
  for (const KeyRange& range : plan.keys)
    texts.push_back(fmt::format("{} from {} to {}{}", range.key, value_text(range, 0), value_text(range, 1),
                                range.logarithmic ? " (by equal factors)" : ""));
  return fmt::format("{}.", fmt::join(texts, "; "));
}

nlohmann::json finite(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::ordered_json run_numbers(const AimPlan& plan, const AimRun& run) {
  nlohmann::ordered_json json;
  json["name"] = run.name;
  std::vector<nlohmann::json> values, readings;
  for (std::size_t k = 0; k < plan.keys.size(); ++k)
    values.push_back(run.place.size() == 0 ? nlohmann::json(nullptr)
                                           : finite(plan.keys[k].value_at(run.place[Eigen::Index(k)])));
  json["values"] = values;
  json["settings"] = run.values;
  std::vector<double> left;
  for (std::size_t w = 0; w < plan.wants.size(); ++w) {
    readings.push_back(finite(run.readings[w].value));
    left.push_back(run.miss[Eigen::Index(w)]);
  }
  json["readings"] = readings;
  json["left"] = left;
  json["steps_not_converged"] = run.steps_not_converged;
  return json;
}

}  // namespace

std::string aim_page_html(const AimPlan& plan, const AimFolder& folder, const AimRuns& runs, const AimRun& best,
                          const AimReport& report) {
  std::string html = embedded("page.html");
  fill_in(html, "title", html_text(title_of(plan)));
  fill_in(html, "style", page_style() + embedded("page.css"));
  fill_in(html, "heading", html_text(title_of(plan)));
  fill_in(html, "summary", html_text(summary_of(plan)));
  fill_in(html, "kind", report.reached ? "reached" : "missed");
  fill_in(html, "verdict", html_text(report.verdict));
  fill_in(html, "strip", png_data_url(read_file(folder.strip())));
  fill_in(html, "plots", plots_of(plan, folder));
  fill_in(html, "head", head_row(plan));
  fill_in(html, "rows", rows_of(plan, runs, best));
  fill_in(html, "lines", html_text(report.lines));
  fill_in(html, "command", html_text(report.command));
  fill_in(html, "made_by", html_text(fmt::format("Made by umax {} on {}.", version_text(), host_description())));
  fill_in(html, "script", embedded("page.js"));
  return html;
}

std::string aim_record(const AimPlan& plan, const AimRuns& runs, const AimRun& best, const AimReport& report) {
  nlohmann::ordered_json json;
  json["program"] = "umax aim";
  json["scene"] = plan.scene.name;
  json["reached"] = report.reached;
  json["verdict"] = report.verdict;
  json["wants"] = nlohmann::json::array();
  for (const Want& want : plan.wants) json["wants"].push_back(want.text);
  json["keys"] = nlohmann::json::array();
  for (const KeyRange& range : plan.keys) json["keys"].push_back(range.key);
  json["best"] = best.name;
  json["lines"] = report.lines;
  json["command"] = report.command;
  json["runs"] = nlohmann::json::array();
  for (const AimRun& run : runs.all()) json["runs"].push_back(run_numbers(plan, run));
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace umax
