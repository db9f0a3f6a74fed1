#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/base/srgb.h"
#include "core/files/read_file.h"
#include "render/annotation/annotate.h"
#include "render/image/colormap.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_colors.h"
#include "tools/pages/compare_report.h"

using namespace umax;

namespace {

Image8 plain(int width, int height, std::uint8_t code) {
  Image8 image(width, height, 3);
  std::fill(image.values.begin(), image.values.end(), code);
  return image;
}

/// OKLab lightness, from its definition.
double lightness(const Vector3f& rgb) {
  const double l =
      std::cbrt(0.4122214708 * double(rgb[0]) + 0.5363325363 * double(rgb[1]) + 0.0514459929 * double(rgb[2]));
  const double m =
      std::cbrt(0.2119034982 * double(rgb[0]) + 0.6806995451 * double(rgb[1]) + 0.1073969566 * double(rgb[2]));
  const double s =
      std::cbrt(0.0883024619 * double(rgb[0]) + 0.2817188376 * double(rgb[1]) + 0.6299787005 * double(rgb[2]));
  return 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
}

}  // namespace

TEST_CASE("colours of values rise evenly in lightness up to the limit") {
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    const double step = lightness(color_of_value((i + 0.99) / 100)) - lightness(color_of_value(i / 100.0));
    worst = std::max(worst, std::abs(step - 0.006 * 0.99));
  }
  CHECK(worst < 0.0025);
}

TEST_CASE("a reached limit has a colour of its own") {
  CHECK(code_of_value(1.0) == code_of_value(1.7));
  const Vector3f at_limit = color_of_value(1), nearly = color_of_value(0.999);
  CHECK((at_limit - nearly).norm() > 0.5f);
  CHECK(at_limit[0] > 10 * at_limit[1]);
  CHECK(code_of_value(-1) == code_of_value(0));
  const auto missing = code_of_value(std::numeric_limits<double>::quiet_NaN());
  CHECK(missing[0] == missing[1]);
}

TEST_CASE("the legend shows every colour of the bar and the limit's cap, in the right part only") {
  Image8 image = plain(320, 180, 128);
  draw_legend(image, {.title = "U / Umax", .ends_at_limit = true});
  CHECK(num_of_color(image, 1) > 30);
  CHECK(num_of_color(image, 0.5) >= 8);
  CHECK(num_of_color(image, 0.002) >= 1);
  for (int y = 0; y < image.height; ++y) REQUIRE(int(image.pixel(160, y)[0]) == 128);

  Image8 without_limit = plain(320, 180, 128);
  draw_legend(without_limit, {.title = "stress [kPa]", .high = 250});
  CHECK(num_of_color(without_limit, 1) == 0);
}

TEST_CASE("a logarithmic legend gives equal factors of 1 + value equal lengths") {
  const Legend legend{.title = "times", .low = 0, .high = 99, .logarithmic = true};
  CHECK(place_on(legend, 0) == 0);
  CHECK(place_on(legend, 9) == Approx(0.5));
  CHECK(place_on(legend, 99) == Approx(1));
  const Legend even{.title = "even", .low = 2, .high = 6};
  CHECK(place_on(even, 3) == Approx(0.25));
  Image8 image = plain(320, 180, 128);
  draw_legend(image, legend);
  CHECK(num_of_color(image, 0.5) >= 8);
}

TEST_CASE("a logarithmic legend that does not begin at 0 gives equal factors of the value equal lengths") {
  const Legend legend{.title = "factor", .low = 0.01, .high = 100, .logarithmic = true};
  CHECK(place_on(legend, 0.01) == 0);
  CHECK(place_on(legend, 1) == Approx(0.5));
  CHECK(place_on(legend, 100) == Approx(1));
}

TEST_CASE("a centred label lies around its place, and captions are drawn with the picture") {
  const auto middle_of = [](const Image8& image, std::uint8_t background) {
    double sum = 0, count = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        if (image.pixel(x, y)[0] != background) sum += x, count += 1;
    REQUIRE(count > 50);
    return sum / count;
  };
  Image8 image = plain(320, 180, 128);
  draw_label(image, "no limit", 0.5f, 0.1f, {.size = 0.1f, .centred = true});
  CHECK(middle_of(image, 128) == Approx(160).margin(2));
  RenderScene scene;
  scene.captions = {{"5 %", 0.25f, 0.8f}};
  const Image8 shown = present(Image(320, 180, 3), scene);
  CHECK(middle_of(shown, shown.pixel(0, 0)[0]) == Approx(80).margin(2));
}

TEST_CASE("values beyond a bar are red only where it ends at a limit") {
  const Legend round{.title = "stretch [%]", .high = 25},
      limit{.title = "stretch [%]", .high = 25, .ends_at_limit = true};
  CHECK(color_on(limit, 25) == color_of_value(1));
  const Legend slack{.title = "stretch [%]", .high = 25, .ends_at_limit = true, .slack = 0.01};
  CHECK(color_on(slack, 24.8) == color_of_value(1));
  CHECK(color_on(slack, 24.7) == color_on(limit, 24.7));
  CHECK(color_on(round, 25) == color_on(round, 40));
  CHECK((color_on(round, 25) - color_of_value(0.999)).norm() < 0.01f);
  CHECK(color_on(round, 5) == color_on(limit, 5));
  CHECK(color_on(round, 5) == color_of_value(0.2));
}

TEST_CASE("labels write light letters where asked, and the same ones every time") {
  Image8 image = plain(200, 100, 40), again = image;
  draw_label(image, "Umax = 100 J", 0.05f, 0.1f, {.size = 0.2f, .backed = false});
  draw_label(again, "Umax = 100 J", 0.05f, 0.1f, {.size = 0.2f, .backed = false});
  CHECK(image.values == again.values);
  int above = 0, below = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) (y < 50 ? above : below) += image.pixel(x, y)[0] > 200;
  CHECK(above > 100);
  CHECK(below == 0);
}

TEST_CASE("a contact sheet holds its pictures unchanged") {
  const std::vector<LabelledImage> pictures = {
      {plain(64, 36, 10), "a"}, {plain(64, 36, 90), "b"}, {plain(64, 36, 200), "c"}};
  const Image8 sheet = contact_sheet(pictures, 2);
  CHECK(sheet.width > 128);
  CHECK(sheet.height > 72);
  for (const auto& [image, label] : pictures) {
    const auto count = std::count(sheet.values.begin(), sheet.values.end(), image.values[0]);
    CHECK(count >= 64 * 36 * 3);
  }
}

TEST_CASE("the comparison page holds three pictures, the numbers and the command") {
  const auto& folder = output_folder();
  const Image8 a = plain(32, 18, 100), b = plain(32, 18, 140);
  write_compare_report(folder / "page.html", {"frame <1>", a, b, flip(a, b), "too different", "cp 'x' 'y'"});
  const std::string page = read_file(folder / "page.html");
  CHECK(page.find("frame &lt;1&gt;") != std::string::npos);
  CHECK(page.find("cp 'x' 'y'") != std::string::npos);
  CHECK(page.find("mean FLIP") != std::string::npos);
  CHECK(page.find("http") == std::string::npos);  // needs nothing from elsewhere
  std::size_t num_pictures = 0;
  for (auto at = page.find("data:image/png;base64,iVBORw0KGgo"); at != std::string::npos;
       at = page.find("data:image/png;base64,iVBORw0KGgo", at + 1))
    ++num_pictures;
  CHECK(num_pictures == 5);
}
