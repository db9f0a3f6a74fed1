// The paper's experiments as a user runs them, in their quick form, and the report that they write.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>

#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/reproduce/report.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const Words quick{"--quick", "--samples", "1", "--quiet"};

/// The fields of a line of a CSV file, quotes removed.
Words fields_of(const std::string& line) {
  Words fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

/// report.csv by "section/table/row/column".
std::map<std::string, double> numbers_of(const fs::path& report) {
  std::map<std::string, double> numbers;
  std::ifstream file(report / "report.csv");
  std::string line;
  std::getline(file, line);
  CHECK(line == "section,table,row,column,unit,value");
  while (std::getline(file, line)) {
    const Words fields = fields_of(line);
    REQUIRE(fields.size() == 6);
    const std::string name = fields[0] + "/" + fields[1] + "/" + fields[2] + "/" + fields[3];
    CHECK(numbers.count(name) == 0);  // every number has a name of its own
    numbers[name] = std::stod(fields[5]);
    CHECK(std::isfinite(numbers[name]));
  }
  return numbers;
}

/// Whether a page refers to anything outside itself.
bool is_self_contained(const std::string& page) {
  static const std::regex reference(R"re((src|href)="([^"]{0,40}))re");
  for (std::sregex_iterator match(page.begin(), page.end(), reference), end; match != end; ++match) {
    const std::string target = (*match)[2];
    if (!target.starts_with("data:") && !target.starts_with("#")) return false;
  }
  if (page.find("url(") != std::string::npos || page.find("@import") != std::string::npos) return false;
  return page.find("<script") == std::string::npos && page.find("<link") == std::string::npos;
}

ReportTable small_table() {
  return {.name = "t\"1\"",
          .caption = "a < b & c",
          .columns = {{"words"}, {"length", "m"}},
          .rows = {{"first, with a comma", {{"x"}, number_cell(1.0 / 3)}}, {"second", {{"y"}, number_cell(NAN)}}}};
}

/// As deep as a prototype of the paper's method found, whatever the report's page says; the exact method agrees.
void check_beams(const std::map<std::string, double>& numbers) {
  const auto tip = [&](const std::string& row, const std::string& column) {
    return numbers.at("figure3/tips/" + row + "/" + column);
  };
  const std::string published = "paper's method and energy", true_energy = "paper's method, true energy",
                    exact = "exact method, true energy";
  const struct {
    const char* row;
    double swing, rest, swing_true, rest_true;
  } expected[] = {{"(i) 150 kPa", -0.960, -0.869, -0.960, -0.869},
                  {"(ii) 150 kPa, U ≤ 1.0 J", -0.917, -0.853, -0.949, -0.869},
                  {"(iii) 150 kPa, U ≤ 0.5 J", -0.855, -0.802, -0.907, -0.848},
                  {"(iv) 150 kPa, U ≤ 0.1 J", -0.603, -0.567, -0.715, -0.673},
                  {"(v) 2 MPa", -0.382, -0.209, -0.382, -0.209}};
  for (const auto& beam : expected) {
    INFO(beam.row);
    CHECK(tip(beam.row, published + ": swing") == Approx(beam.swing).margin(1e-3));
    CHECK(tip(beam.row, published + ": rest") == Approx(beam.rest).margin(1e-3));
    CHECK(tip(beam.row, true_energy + ": swing") == Approx(beam.swing_true).margin(1e-3));
    CHECK(tip(beam.row, true_energy + ": rest") == Approx(beam.rest_true).margin(1e-3));
    CHECK(tip(beam.row, exact + ": swing") == Approx(beam.swing_true).margin(5e-3));
    CHECK(tip(beam.row, exact + ": rest") == Approx(beam.rest_true).margin(1e-3));
  }

  // equally deformed where a moment acts, not at the free end; 1 J carries nothing at rest
  const auto spread = [&](const std::string& row, const std::string& column) {
    return numbers.at("figure3/spread/" + row + "; exact method, true energy/" + column);
  };
  CHECK(spread("(iv) 150 kPa, U ≤ 0.1 J", "share >= 0.99") == Approx(75));
  CHECK(spread("(iv) 150 kPa, U ≤ 0.1 J", "minimum") < 0.1);
  CHECK(spread("(iv) 150 kPa, U ≤ 0.1 J", "maximum") <= 1.001);
  CHECK(spread("(ii) 150 kPa, U ≤ 1.0 J", "active limits, at rest") == 0);
}

/// The limited sphere does not bounce; the others do.
void check_spheres(const std::map<std::string, double>& numbers) {
  for (const std::string way : {"paper's method and energy", "exact method, true energy"}) {
    INFO(way);
    const auto sphere = [&](const std::string& row, const std::string& column) {
      return numbers.at("figure4/bounce/" + row + "; " + way + "/" + column);
    };
    const std::string top = "highest centre after it";
    CHECK(sphere("150 kPa", top) == Approx(1.27).margin(0.03));
    CHECK(sphere("1 MPa", top) == Approx(1.33).margin(0.03));
    CHECK(sphere("150 kPa, U ≤ 500 J", top) < 1.01);  // 1 m: it lies on the ground
    CHECK(sphere("150 kPa", "lowest centre") == Approx(0.545).margin(0.005));
    CHECK(sphere("150 kPa, U ≤ 500 J", "lowest centre") > 0.77);
    CHECK(sphere("150 kPa, U ≤ 500 J", "largest U/U_max") <= (way[0] == 'p' ? 1.01 : 1.001));
  }
}

}  // namespace

TEST_CASE("a report's numbers keep their digits and their names in report.csv", "[reproduce]") {
  const Report report{.made_by = "test", .sections = {{.name = "s", .title = "S", .blocks = {small_table()}}}};
  CHECK(report_csv(report) ==
        "section,table,row,column,unit,value\n"
        "s,\"t\"\"1\"\"\",\"first, with a comma\",length,m,0.333333333333\n");
}

TEST_CASE("numbers are shown with the digits that are asked for", "[reproduce]") {
  CHECK(number_cell(2583.4).text == "2583");
  CHECK(number_cell(0.0012345).text == "0.00123");
  CHECK(number_cell(-1.00951, 5).text == "-1.0095");
  CHECK(number_cell(43243, 7).text == "43243");
  CHECK(number_cell(NAN).text == "–");
  CHECK_FALSE(number_cell(NAN).number);
}

TEST_CASE("a report's page shows words as words and needs no other file", "[reproduce]") {
  ReportPlot plot;
  plot.caption = "a plot";
  PlotPanel& panel = plot.plot.panels.emplace_back();
  panel.series.push_back({"s", {0, 1}, {0, 1}});
  const Report report{
      .made_by = "test",
      .sections = {{.name = "s",
                    .title = "<S>",
                    .blocks = {small_table(), plot, ReportText{"<script>alert(1)</script>", ReportVoice::paper}}}}};
  const std::string page = report_page(report);
  CHECK(is_self_contained(page));
  CHECK(page.find("&lt;S&gt;") != std::string::npos);
  CHECK(page.find("a &lt; b &amp; c") != std::string::npos);
  CHECK(page.find("0.333") != std::string::npos);
  CHECK(page.find("data:image/svg+xml;base64,") != std::string::npos);
  CHECK_FALSE(is_self_contained(page + "<img src=\"picture.png\">"));
}

TEST_CASE("umax reproduce shows the beams and the spheres of the paper, and goes on where it stopped",
          "[reproduce][slow]") {
  const TemporaryFolder temporary;
  const fs::path report = temporary / "report";
  const Words output{"-o", report.string()};
  REQUIRE(exit_code_of(Words{"reproduce", "figure3", "figure4"} + output + quick) == 0);
  const std::map<std::string, double> numbers = numbers_of(report);
  check_beams(numbers);
  check_spheres(numbers);

  const std::string page = file_text(report / "index.html"), table = file_text(report / "report.csv");
  CHECK(is_self_contained(page));
  CHECK(page.find("data:image/png;base64,") != std::string::npos);
  CHECK(fs::exists(report / "figure3.png"));
  CHECK(fs::exists(report / "figure4.png"));

  // it is not touched unasked
  CHECK(exit_code_of(Words{"reproduce", "figure3"} + output + quick) == 73);

  // what is missing is made again, and nothing else; one experiment is asked for, and the page keeps the other
  const fs::path run = report / "runs/figure3-iv-exact-swing", kept = report / "runs/figure3-iv-exact-rest";
  const auto written = fs::last_write_time(kept / "run.json");
  const std::map<std::string, std::string> states = states_of(run);
  for (int frame = 60; frame <= 99; ++frame) fs::remove(run / "states" / ("00" + std::to_string(frame) + ".state"));
  fs::remove(report / "index.html");
  fs::remove(report / "tiles/figure3-1.png");
  make_file(report / "tiles/.figure3-1.png.part-1", "half");
  // of a call that was killed after its last state
  const fs::path left = report / "runs/figure3-i-exact-rest";
  const std::string motion = file_text(left / "motion.json");
  fs::remove(left / "motion.json");
  fs::create_directory(left / ".umax");
  REQUIRE(exit_code_of(Words{"reproduce", "figure3", "--resume"} + output + quick) == 0);
  CHECK(states_of(run) == states);
  CHECK(file_text(report / "report.csv") == table);
  CHECK(file_text(report / "index.html") == page);
  CHECK(fs::last_write_time(kept / "run.json") == written);
  CHECK(file_text(left / "motion.json") == motion);
  CHECK(!has_half_written_files(report));
}

TEST_CASE("umax reproduce corrects the paper's equations with numbers, and one page gathers what is asked for",
          "[reproduce]") {
  const TemporaryFolder temporary;
  const Words output{"-o", (temporary / "report").string()};
  REQUIRE(exit_code_of(Words{"reproduce", "corrections"} + output + quick) == 0);
  const std::map<std::string, double> numbers = numbers_of(temporary / "report");
  CHECK(numbers.size() > 20);
  for (const auto& [name, value] : numbers)
    if (name.ends_with("as corrected, largest")) {
      INFO(name);
      CHECK(value < 1e-6);
    }
  CHECK(is_self_contained(file_text(temporary / "report/index.html")));
}

TEST_CASE("umax reproduce refuses what it cannot do", "[reproduce]") {
  const TemporaryFolder temporary;
  const Words output{"-o", (temporary / "report").string()};
  const ProcessResult unknown = umax_program(Words{"reproduce", "figure2"} + output);
  CHECK(unknown.exit_code == 2);
  CHECK(unknown.messages.find("figure3") != std::string::npos);
  CHECK(exit_code_of(Words{"reproduce", "figure3", "--set", "body.beam.limit.energy=2 J"} + output) == 2);
  CHECK_FALSE(fs::exists(temporary / "report"));  // found out before anything was made

  fs::create_directory(temporary / "other");
  make_file(temporary / "other/thesis.txt", "mine");
  CHECK(exit_code_of({"reproduce", "corrections", "--overwrite", "-o", (temporary / "other").string()}) == 73);
  CHECK(file_text(temporary / "other/thesis.txt") == "mine");
}

TEST_CASE("the paper's gain of true derivatives comes from its energy", "[reproduce][slow]") {
  const TemporaryFolder temporary;
  const fs::path report = temporary / "report";
  REQUIRE(exit_code_of(Words{"reproduce", "convergence", "-o", report.string()} + quick) == 0);
  const std::map<std::string, double> numbers = numbers_of(report);
  const std::string gain = "gain: warped / paper's - 1";
  const auto at = [&](const std::string& row) { return numbers.at("convergence/paper-energy-iterations/" + row); };
  CHECK(at("U ≤ 0.5 J/" + gain) == Approx(61).margin(2));
  CHECK(at("U ≤ 0.01 J/" + gain) == Approx(93).margin(2));
  CHECK(at("mean gain/" + gain) == Approx(76).margin(2));
  CHECK(numbers.at("convergence/true-energy-iterations/largest gain/" + gain) == 0);
}
