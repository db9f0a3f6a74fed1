#include "tools/reproduce/corrections.h"

#include <cmath>
#include <filesystem>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// The row of an equation whose printed form or measure has the given words in it.
Correction find(const std::string& equation, const std::string& words) {
  static const std::vector<Correction> rows = corrections();
  for (const Correction& row : rows)
    if (row.equation == equation && (row.printed + row.measure).find(words) != std::string::npos) return row;
  FAIL("no correction of Eq. " << equation << " with \"" << words << "\"");
  return {};
}

}  // namespace

TEST_CASE("every equation of the paper is right to 1e-8 as corrected, over many hexes") {
  const std::vector<Correction> rows = corrections();
  CHECK(rows.size() >= 20);
  for (const Correction& row : rows) {
    CAPTURE(row.equation, row.printed, row.measure);
    CHECK(row.num_samples >= 20);
    CHECK(std::isfinite(row.error_printed));
    CHECK(row.lowest_printed >= 0);
    CHECK(row.lowest_printed <= row.error_printed * (1 + 1e-12));
    CHECK(row.error_printed <= row.highest_printed * (1 + 1e-12));
    CHECK(row.error_corrected <= 1e-8);
    for (const std::string* text : {&row.equation, &row.printed, &row.corrected, &row.measure, &row.remark, &row.test})
      CHECK_FALSE(text->empty());
  }
}

TEST_CASE("corrections are the same numbers every time") {
  const std::vector<Correction> first = corrections(), second = corrections();
  REQUIRE(first.size() == second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    CHECK(first[i].error_printed == second[i].error_printed);
    CHECK(first[i].error_corrected == second[i].error_corrected);
    CHECK(first[i].remark == second[i].remark);
  }
}

TEST_CASE("what the paper prints wrong is off by what theory says") {
  // Eq. 6: rank one; Eq. 9: no shear at all, and the square of half the edge
  CHECK(find("6", "each term").lowest_printed > 1);
  CHECK(find("9", "3 × 24").lowest_printed == Approx(1).epsilon(1e-12));
  const Correction stiffness = find("9", "natural");
  CHECK(stiffness.lowest_printed > 1 - 0.13 * 0.13);
  CHECK(stiffness.highest_printed < 1 - 0.03 * 0.03);

  // Eq. 16: 2 - 2 mu sum eps_ik^2 / e_true, less 1
  CHECK(find("13, 16", "[100]").error_printed == Approx(1).epsilon(1e-12));
  CHECK(find("13, 16", "[110]").error_printed == Approx(1 - 1.3 / 2).epsilon(1e-12));
  CHECK(find("13, 16", "[111]").error_printed == Approx(1 - 1.3 * 2 / 3).epsilon(1e-12));
  CHECK(find("13, 16", "along the cell").error_printed == Approx(1).epsilon(1e-12));
  CHECK(find("13, 16", "45°").highest_printed < 1e-12);
  CHECK(find("13, 16", "any").highest_printed <= 1);
  CHECK(find("15", "").highest_printed < 1e-9);

  // Eq. 17: 5 to 42 %, 17 % on average; 87 to 97 %
  const Correction modulus = find("17", "E₂");
  CHECK(modulus.lowest_printed > 0.04);
  CHECK(modulus.error_printed == Approx(0.17).margin(0.03));
  CHECK(modulus.highest_printed < 0.42);
  const Correction derivatives = find("17", "H = ");
  CHECK(derivatives.lowest_printed > 0.87);
  CHECK(derivatives.highest_printed < 0.971);

  // the rotation: 1.7 % at the centre, 17 % of a Kuhn tetrahedron for the true energy
  CHECK(find("17", "from the centre").error_printed == Approx(0.017).margin(0.01));
  CHECK(find("17", "tetrahedron").error_printed > 0.1);
  const Correction warped = find("sect. 4.2", "");
  CHECK(warped.lowest_printed > 0.1);
  CHECK(warped.highest_printed < 0.5);
}

TEST_CASE("only the centre's rotation gives a cube one energy under all its symmetries") {
  const Correction kuhn = find("sect. 3.3", "innermost"), inner = find("sect. 3.3", "into five");
  CHECK(kuhn.lowest_printed > 0.05);
  CHECK(inner.lowest_printed > 1e-4);
  CHECK(inner.error_printed < 0.2 * kuhn.error_printed);
  CHECK(kuhn.error_corrected < 1e-12);
  CHECK(inner.error_corrected < 1e-12);
}

TEST_CASE("the literal form of Eq. 21 gets worse the tighter the limit is") {
  const double loose = find("21, 23", "1/2").error_printed, tight = find("21, 23", "1/10 ").error_printed;
  CHECK(loose < 1);
  CHECK(tight > 2);
  CHECK(find("21, 23", "1/100").error_printed > 5 * tight);
}

TEST_CASE("every correction names a test that is there") {
  std::string tests;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / "tests"))
    if (entry.path().extension() == ".cpp") tests += file_text(entry.path());
  for (const Correction& row : corrections()) {
    CAPTURE(row.equation, row.test);
    CHECK(tests.find("TEST_CASE(\"" + row.test + "\")") != std::string::npos);
  }
}
