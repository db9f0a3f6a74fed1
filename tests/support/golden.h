// Pictures against references in tests/golden: bit-near on the machine that made them, tolerant of other processors.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "render/annotation/annotate.h"
#include "render/image/image_io.h"
#include "tests/support/catch.h"
#include "tools/pages/compare_report.h"

namespace umax::test {

/// A picture passes when at most `percent` of its pixels differ by more than `fail` in a channel, none by more than
/// `hard_fail`, and its mean FLIP is at most `mean_flip`.
struct GoldenTolerance {
  int fail = 3;             // [1/255]
  double percent = 1;       // [%] of the pixels
  int hard_fail = 48;       // [1/255] an edge sample may fall on the other side
  double mean_flip = 0.01;  // [-]
};

struct PixelDifference {
  int largest = 0;     // [1/255]
  double percent = 0;  // [%] of the pixels beyond GoldenTolerance::fail
};

inline PixelDifference pixel_difference(const Image8& a, const Image8& b, int fail) {
  PixelDifference result;
  std::size_t num_beyond = 0;
  for (std::size_t i = 0; i < a.values.size(); i += a.channels) {
    int largest = 0;
    for (int c = 0; c < a.channels; ++c)
      largest = std::max(largest, std::abs(int(a.values[i + c]) - int(b.values[i + c])));
    result.largest = std::max(result.largest, largest);
    num_beyond += largest > fail;
  }
  result.percent = 100.0 * double(num_beyond) / double(std::max<std::size_t>(a.values.size() / a.channels, 1));
  return result;
}

struct GoldenOutcome {
  bool passed = false;
  std::string verdict;
  std::filesystem::path page;  // of a failure: reference, result, difference and the command that accepts the result
};

/// Compares a picture with its reference; a failure leaves NAME.html and NAME.png in `folder`.
inline GoldenOutcome compare_with_golden(const std::string& name, const Image8& reference, const Image8& result,
                                         const GoldenTolerance& tolerance, const std::filesystem::path& folder) {
  const PixelDifference pixels = pixel_difference(reference, result, tolerance.fail);
  const FlipResult seen = flip(reference, result);
  GoldenOutcome outcome;
  outcome.passed =
      pixels.percent <= tolerance.percent && pixels.largest <= tolerance.hard_fail && seen.mean <= tolerance.mean_flip;
  char verdict[256];
  std::snprintf(
      verdict, sizeof verdict,
      "%.2f %% of the pixels differ by more than %d/255 (allowed %.2f %%), the worst by %d/255 (allowed %d), mean "
      "FLIP %.5f (allowed %.5f)",
      pixels.percent, tolerance.fail, tolerance.percent, pixels.largest, tolerance.hard_fail, seen.mean,
      tolerance.mean_flip);
  outcome.verdict = verdict;
  if (outcome.passed) return outcome;

  std::filesystem::create_directories(folder);
  outcome.page = folder / (name + ".html");
  write_png(folder / (name + ".png"), result);
  const auto target = std::filesystem::path(UMAX_SOURCE_DIR) / "tests/golden" / (name + ".png");
  const std::string command = "cp '" + (folder / (name + ".png")).string() + "' '" + target.string() + "'";
  write_compare_report(outcome.page, {name, reference, result, seen, verdict, command});
  return outcome;
}

/// Compares with tests/golden/NAME.png. With UMAX_UPDATE_GOLDEN=1 in the environment it writes the reference instead.
/// A failure leaves its page in the build's test-output/golden and says where.
inline void check_golden(const std::string& name, const Image8& result, const GoldenTolerance& tolerance = {}) {
  const auto path = std::filesystem::path(UMAX_SOURCE_DIR) / "tests/golden" / (name + ".png");
  if (const char* update = std::getenv("UMAX_UPDATE_GOLDEN"); update && std::string(update) == "1") {
    write_png(path, result);
    WARN("reference written: " << path.string());
  }
  INFO("reference " << path.string() << "; UMAX_UPDATE_GOLDEN=1 in the environment writes it anew");
  REQUIRE(std::filesystem::exists(path));
  const Image8 reference = read_png8(path);
  REQUIRE(reference.width == result.width);
  REQUIRE(reference.height == result.height);
  REQUIRE(reference.channels == result.channels);
  const GoldenOutcome outcome =
      compare_with_golden(name, reference, result, tolerance, std::filesystem::path(UMAX_TEST_OUTPUT) / "golden");
  INFO(outcome.verdict);
  INFO("page: " << outcome.page.string());
  CHECK(outcome.passed);
}

/// The same for a scene-linear picture, shown with the scene's exposure and legend.
inline void check_golden(const std::string& name, const Image& linear, const RenderScene& scene,
                         const GoldenTolerance& tolerance = {}) {
  check_golden(name, present(linear, scene), tolerance);
}

}  // namespace umax::test
