// Measurements as files: what is read, what is refused, what umax fit makes of them.
#include <cmath>

#include "core/base/error.h"
#include "scenes/scene.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tests/tools/program.h"
#include "tools/fit/csv_table.h"
#include "tools/fit/measurements.h"

using namespace umax;
using umax::test::contains;

namespace {

Measurements parsed(const std::string& text, const MeasurementOptions& options = {}) {
  return parse_measurements(text, "data.csv", options);
}

/// The message that a bad file gets; empty if it gets none, or another exit code than 65.
std::string complaint(const std::string& text, const MeasurementOptions& options = {}) {
  try {
    parsed(text, options);
  } catch (const Error& error) {
    return error.fault() == Fault::bad_data ? error.what() : "";
  }
  return "";
}

const std::string good_rows = "1,10\n2,20\n3,30\n4,40\n5,50\n";

}  // namespace

TEST_CASE("CSV fields may be quoted, hold commas, quotes and line ends") {
  const CsvTable table = parse_csv("\xEF\xBB\xBF# note\r\na , \"b,\"\"c\"\"\"\r\n1,\"2\n3\"\r\n\r\n 4 ,\n", "x");
  REQUIRE(table.header.fields == std::vector<std::string>{"a", "b,\"c\""});
  REQUIRE(table.rows.size() == 2);
  CHECK(table.rows[0].fields == std::vector<std::string>{"1", "2\n3"});
  CHECK(table.rows[1].fields == std::vector<std::string>{"4", ""});
  CHECK(table.header.line == 2);
  CHECK(table.rows[0].line == 3);
  CHECK(table.rows[1].line == 6);
}

TEST_CASE("units in the header bring measurements to stretch and stress") {
  const Measurements a = parsed("Stretch [%],Force [N]\n" + good_rows, {.area = 1e-4});
  CHECK(a.points[2].stretch == Approx(0.03));
  CHECK(a.points[2].stress == Approx(300e3));
  CHECK(a.points[2].line == 4);
  const Measurements b = parsed("nominal stress (kPa),stretch ratio\n10,1.1\n20,1.2\n30,1.3\n5,1.05\n1,1.01\n");
  CHECK(b.points[1].stretch == Approx(0.2));
  CHECK(b.points[1].stress == Approx(20e3));
  const Measurements c =
      parsed("displacement [mm],force [N],lateral strain [%]\n0,0,\n1,5,-1\n2,10,-2\n3,15,-3\n4,20,-4\n",
             {.length = 0.05, .area = 1e-4});
  CHECK(c.points[2].stretch == Approx(0.04));
  CHECK(c.points[2].lateral_stretch == Approx(-0.02));
  CHECK(std::isnan(c.points[0].lateral_stretch));
  CHECK(c.has_lateral);
}

TEST_CASE("columns are known by their usual spellings, and how each was read is said") {
  const std::string rows = "0.1,1\n0.2,2\n0.3,3\n0.05,0.5\n0.15,1.5\n";
  const auto check = [&](const std::string& header, double stretch, double stress, const std::string& part) {
    const Measurements data = parsed(header + "\n" + rows, {.length = 1, .area = 1});
    CAPTURE(header, data.reading);
    CHECK(data.points[1].stretch == Approx(stretch));
    CHECK(data.points[1].stress == Approx(stress));
    CHECK(contains(data.reading, part));
    CHECK(data.warnings.empty());
  };
  check("strain,stress_MPa", 0.2, 2e6, "\"stress_MPa\" as force over the section at rest in MPa");
  check("stretch,force_N", 0.2, 2, "\"stretch\" as change of length over length (0.1 is 10 %)");
  check("Strain_%,Stress / kPa", 0.002, 2e3, "\"Strain_%\" as change of length over length in %");
  check("Engineering Strain (mm/mm),Nominal_Stress (N/mm^2)", 0.2, 2e6, "in N/mm^2");
  check("eng_strain_pct,load_kn", 0.002, 2e3, "\"load_kn\" as force in kN");
  check("Extension (mm),Force N", 0.0002, 2, "\"Extension (mm)\" as change of length in mm");
  check("elongation [%],eng. stress [MPa]", 0.002, 2e6, "\"elongation [%]\" as change of length over length in %");
  check("tensile-strain,tensile-stress_mpa", 0.2, 2e6, "in MPa");
  check("shear_strain,shear_stress_kPa", 0.2, 2e3, "in kPa");
}

TEST_CASE("semicolons and tabs separate columns, numbers may have decimal commas, and a second line units") {
  const auto check = [&](const std::string& text, const std::string& part) {
    const Measurements data = parsed(text, {.length = 1, .area = 1});
    CAPTURE(text, data.reading);
    REQUIRE(data.points.size() == 5);
    CHECK(data.points[1].stretch == Approx(0.2));
    CHECK(data.points[1].stress == Approx(2e3));
    CHECK(data.warnings.empty());
    CHECK(contains(data.reading, part));
    CHECK(contains(data.reading, ";") == !part.empty());
  };
  check("strain,stress [kPa]\n.1,1\n.2,2\n.3,3\n.05,.5\n.15,1.5\n", "");
  check("strain;stress [kPa]\n0.1;1\n0.2;2\n0.3;3\n0.05;0.5\n0.15;1.5\n", "; separated by semicolons");
  check("# tab\tcomma,comma,\nstrain\tstress [kPa]\n0.1\t1\n0.2\t2\n0.3\t3\n0.05\t0.5\n0.15\t1.5\n",
        "; separated by tabs");
  check("\"strain\";\"stress (kPa)\"\r\n0,1;1\r\n0,2;2,0\r\n0,3;3\r\n0,05;0,5\r\n1,5e-1;1,5\r\n",
        "; separated by semicolons, commas in numbers taken for decimal points");
  check("Displacement;Force\n(mm);(kN)\n100;1\n200;2\n300;3\n50;0,5\n150;1,5\n",
        "\"Displacement [mm]\" as change of length in mm, \"Force [kN]\" as force in kN; separated by semicolons, "
        "commas in "
        "numbers taken for decimal points, units from line 2");
  check("extension,load\nmm,kN\n100,1\n200,2\n300,3\n50,0.5\n150,1.5\n", "; units from line 2");
  check("strain,stress [kPa],\n-,kPa,\n0.1,1,\n0.2,2,\n0.3,3,,\n0.05,0.5,\n0.15,1.5,\n", "; units from line 2");
}

TEST_CASE("a column called stretch is length over length where its numbers are 1 at rest") {
  const std::string ratios = "1.1,10\n1.2,20\n1.3,30\n1.05,5\n1.15,15\n";
  const Measurements rising = parsed("stretch,stress_kPa\n" + ratios);
  CHECK(rising.points[1].stretch == Approx(0.2));
  CHECK(contains(rising.reading, "\"stretch\" as length over length at rest"));
  CHECK(parsed("lambda,stress_kPa\n" + ratios).points[1].stretch == Approx(0.2));
  const Measurements pressed =
      parsed("stretch,stress_kPa\n0.9,10\n0.8,20\n0.7,30\n0.95,5\n0.85,15\n", {.test = TestKind::compression});
  CHECK(pressed.points[1].stretch == Approx(-0.2));
  CHECK(pressed.points[1].stress == Approx(-20e3));
  // large changes that are 0 at rest stay changes; so do those that have a unit
  const Measurements changes = parsed("stretch,stress_kPa\n0.2,2\n0.8,20\n1.5,30\n2,35\n3,40\n");
  CHECK(changes.points[4].stretch == Approx(3));
  CHECK(parsed("stretch [%],stress_kPa\n" + ratios).points[1].stretch == Approx(0.012));
}

TEST_CASE("compression is negative, whichever way it was written down") {
  const std::string rows = "0.1,10\n0.2,20\n0.3,30\n0.05,5\n0.15,15\n";
  const std::string ratios = "stretch ratio,stress [kPa]\n0.9,10\n0.8,20\n0.7,30\n0.95,5\n0.85,15\n";
  const std::string negative = "strain,stress [kPa]\n-0.1,-10\n-0.2,-20\n-0.3,-30\n-0.05,-5\n-0.15,-15\n";
  for (const std::string& text : {"strain,stress [kPa]\n" + rows, ratios, negative}) {
    const Measurements data = parsed(text, {.test = TestKind::compression});
    CAPTURE(text);
    CHECK(data.points[1].stretch == Approx(-0.2));
    CHECK(data.points[1].stress == Approx(-20e3));
  }
}

TEST_CASE("bad measurements are refused with line, column, value and remedy") {
  const MeasurementOptions sized{.length = 0.05, .area = 1e-4};
  const std::string header = "stretch [%],force [N]\n";
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases{
      {"", {"data.csv", "empty"}},
      {"# nothing\n\n", {"empty"}},
      {std::string("\x7f"
                   "ELF\x02\x00\x01",
                   7),
       {"no text"}},
      {header, {"0 of 0", "at least 5"}},
      {header + "1,10\n2,20\n3,30\n", {"3 of 3", "at least 5"}},
      {header + "1,10\n2,abc\n" + good_rows, {"data.csv:3", "force [N]", "\"abc\"", "write a number"}},
      {header + "1,10\n2,1e999\n" + good_rows, {"data.csv:3", "1e999"}},
      {header + "1,10\n2,inf\n" + good_rows, {"data.csv:3", "inf"}},
      {header + "1,10\n2,20,7\n" + good_rows, {"data.csv:3", "needs 2 fields", "got 3"}},
      {header + "1,10\n1,5,10\n" + good_rows, {"data.csv:3", "not commas"}},
      {header + "1,10\n\"2,20\n" + good_rows, {"data.csv:3", "never ends"}},
      {header + "1,10\n-130,20\n" + good_rows, {"data.csv:3", "-130 %", "stretch ratio"}},
      {"stretch [%];force [N]\n1;10\n2\n", {"data.csv:3", "needs 2 fields"}},
      {"stretch [%],force\nmm,N\n" + good_rows, {"data.csv:2", "another unit than the title", "mm below"}},
      {"stretch [%]\n1\n2\n", {"data.csv:1", "lacks a column of force"}},
      {"force [N],colour\n1,2\n", {"lacks a column of stretch", "colour"}},
      {"stretch [%],force [mm]\n" + good_rows, {"data.csv:1", "wrong kind of unit", "mm", "kN"}},
      {"stretch [%],force [bananas]\n" + good_rows, {"bananas"}},
      {"stretch [%],force\n" + good_rows, {"has no unit"}},
      {"stretch [mm],force [N]\n" + good_rows, {"wrong kind of unit", "stretch [mm]"}},
      {"stretch [%],strain,force [N]\n1,1,1\n", {"two columns", "strain"}},
      {header + "1,10\n2,10\n3,10\n4,10\n5,10\n", {"3 different forces"}},
      {header + "1,10\n1,20\n1,30\n1,40\n1,50\n", {"3 different stretches"}},
      {header + "-1,10\n-2,20\n-3,30\n-4,40\n-5,50\n", {"fall where forces rise", "--test compression"}},
      {"strain,force [N]\n1.0,0\n1.1,10\n1.2,20\n1.3,30\n1.4,40\n", {"data.csv:2", "stretch ratio"}},
      {"stretch [1],force [N]\n1.0,0\n1.1,10\n0.9,20\n1.3,30\n1.4,40\n", {"data.csv:2", "stretch ratio"}},
      {"true stress,strain\n" + good_rows, {"lacks a column of force", "true stress"}},
      {"strain,force_mm\n" + good_rows, {"wrong kind of unit", "force_mm"}},
      {header + "nan,1\n,2\n3,30\n4,40\n5,50\n6,60\n", {"4 of 6"}},
  };
  for (const auto& [text, parts] : cases) {
    const std::string message = complaint(text, sized);
    CAPTURE(text, message);
    CHECK(!message.empty());
    for (const std::string& part : parts) {
      CAPTURE(part);
      CHECK(contains(message, part));
    }
  }
}

TEST_CASE("rows without numbers and columns that nobody asked for are ignored, and that is said") {
  const Measurements data = parsed(
      "time [s],stretch [%],force [N]\n0,NaN,1\n" + std::string("1,1,10\n2,2,20\n3,,30\n4,4,40\n5,5,50\n6,3,30\n"),
      {.area = 1e-4});
  CHECK(data.points.size() == 5);
  REQUIRE(data.warnings.size() == 2);
  CHECK(contains(data.warnings[0], "time [s]"));
  CHECK(contains(data.warnings[1], "2 rows (lines 2, 5)"));
}

TEST_CASE("sizes that the columns need are asked for") {
  CHECK(error_code_of([] { parsed("stretch [%],force [N]\n" + good_rows); }) == 2);
  CHECK(error_code_of([] { parsed("displacement [mm],stress [kPa]\n" + good_rows); }) == 2);
}

TEST_CASE("umax fit writes a snippet that a scene takes, and a plot") {
  TemporaryFolder folder;
  std::string rows = "# silicone\ndisplacement [mm],force [N],note\n";
  for (int i = 1; i <= 30; ++i)
    rows += std::to_string(std::min(0.5 * i, 10.0) + 0.02 * ((i * 7) % 5 - 2)) + "," + std::to_string(0.1 * i) + ",x\n";
  make_file(folder / "data.csv", rows);
  const std::string output = (folder / "out").string();
  const Words call{"fit", (folder / "data.csv").string(), "-o", output, "--length", "50 mm", "--area", "25 mm^2"};
  const ProcessResult result = umax_program(call);
  REQUIRE(result.exit_code == 0);
  CHECK(contains(result.messages, "note"));  // the column that was ignored
  const std::string snippet = file_text(folder / "out" / "material.toml");
  CHECK(contains(file_text(folder / "out" / "fit.svg"), "<svg"));
  CHECK(!has_half_written_files(folder.path()));

  // stress 0.1 N / 25 mm^2 = 4 kPa for 1 % of stretch; the limit is 20 %
  const Scene scene = parse_scene({.text = "[body.block]\nshape = \"box\"\n" + snippet});
  REQUIRE(scene.bodies.size() == 1);
  CHECK(scene.bodies[0].material.young.at(0) == Approx(400e3).epsilon(0.01));
  CHECK(scene.bodies[0].limit.value.at(0) == Approx(0.2).epsilon(0.01));

  CHECK(exit_code_of(call) == 73);
  CHECK(exit_code_of(call + Words{"--overwrite"}) == 0);
  CHECK(file_text(folder / "out" / "material.toml") == snippet);
  make_file(folder / "other" / "precious.txt", "x");
  CHECK(exit_code_of({"fit", (folder / "data.csv").string(), "-o", (folder / "other").string(), "--length", "50 mm",
                      "--area", "25 mm^2", "--overwrite"}) == 73);
}

TEST_CASE("umax fit tells wrong usage and missing files") {
  TemporaryFolder folder;
  const std::string output = (folder / "out").string(), missing = (folder / "none.csv").string();
  make_file(folder / "data.csv", "stretch [%],stress [kPa]\n" + good_rows);
  const std::string data = (folder / "data.csv").string();
  CHECK(exit_code_of({"fit"}) == 2);
  CHECK(exit_code_of({"fit", missing, "-o", output}) == 66);
  CHECK(exit_code_of({"fit", data, "-o", output, "--test", "torsion"}) == 2);
  CHECK(exit_code_of({"fit", data, "-o", output, "--area", "5 mm"}) == 2);
  CHECK(exit_code_of({"fit", data, "-o", output, "--length", "-5 mm"}) == 2);
  CHECK(exit_code_of({"fit", data, "-o", output, "--cells", "5"}) == 2);
  CHECK(!std::filesystem::exists(output));
}

TEST_CASE("the shipped measurements are fitted, and the misfit of a linear law is shown") {
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(UMAX_SOURCE_DIR) / "scenes/measurements")) {
    CAPTURE(entry.path());
    TemporaryFolder folder;
    const ProcessResult result = umax_program({"fit", entry.path().string(), "-o", (folder / "out").string()});
    CHECK(result.exit_code == 0);
    CHECK(contains(result.output, "misfit"));
    CHECK(result.messages.empty());
    CHECK(contains(result.output, "≥"));  // rubber at such stretches is at no limit
  }
}
