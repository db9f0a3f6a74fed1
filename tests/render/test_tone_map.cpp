#include <tbb/global_control.h>

#include <cmath>

#include "core/base/srgb.h"
#include "render/image/tone_map.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

Image one_pixel(float r, float g, float b) {
  Image image(1, 1, 3);
  image.values = {r, g, b};
  return image;
}

/// Chroma as the spread of the codes.
int spread(const Image8& image) {
  return std::max({image.values[0], image.values[1], image.values[2]}) -
         std::min({image.values[0], image.values[1], image.values[2]});
}

}  // namespace

TEST_CASE("the filmic curve rises from black to white and keeps greys grey") {
  Image ramp(2048, 1, 3);
  for (int x = 0; x < ramp.width; ++x) std::fill_n(ramp.pixel(x, 0), 3, 8.0f * std::pow(float(x) / 2047, 3.0f));
  const Image8 shown = tone_map(ramp);
  CHECK(shown.pixel(0, 0)[0] == 0);
  CHECK(shown.pixel(2047, 0)[0] == 255);
  int num_falling = 0, num_coloured = 0;
  for (int x = 0; x < ramp.width; ++x) {
    const auto* pixel = shown.pixel(x, 0);
    num_falling += x > 0 && pixel[0] < shown.pixel(x - 1, 0)[0];
    num_coloured += pixel[0] != pixel[1] || pixel[1] != pixel[2];
  }
  CHECK(num_falling == 0);
  CHECK(num_coloured == 0);
}

TEST_CASE("mid grey stays mid grey, shadows get darker, highlights do not clip") {
  const auto code = [](float value) { return int(tone_map(one_pixel(value, value, value)).values[0]); };
  const auto plain = [](float value) { return int(byte_from_unit(srgb_from_linear(value))); };
  CHECK(std::abs(code(0.18f) - plain(0.18f)) <= 4);
  CHECK(code(0.02f) < plain(0.02f));
  CHECK(code(1.0f) > 190);
  CHECK(code(1.0f) < 240);
  CHECK(code(4.0f) > code(2.0f));
  CHECK(code(100.0f) == 255);
}

TEST_CASE("mid-tone colours keep their saturation, bright ones run to white") {
  const Image8 plain = tone_map(one_pixel(0.35f, 0.12f, 0.06f), {.curve = ToneCurve::standard});
  CHECK(spread(tone_map(one_pixel(0.35f, 0.12f, 0.06f))) >= spread(plain) - 4);
  CHECK(spread(tone_map(one_pixel(20, 4, 2))) < spread(tone_map(one_pixel(2, 0.4f, 0.2f))));
}

TEST_CASE("one stop doubles the light and the standard curve is sRGB") {
  const Image8 doubled = tone_map(one_pixel(0.1f, 0.2f, 0.3f), {.exposure_stops = 1});
  CHECK(doubled.values == tone_map(one_pixel(0.2f, 0.4f, 0.6f)).values);
  const Image8 standard = tone_map(one_pixel(0.5f, 2.0f, -1.0f), {.curve = ToneCurve::standard});
  CHECK(standard.values == std::vector<std::uint8_t>{188, 255, 0});
}

TEST_CASE("what is not a number is shown black, infinity white") {
  const float nan = std::nanf(""), infinity = INFINITY;
  CHECK(tone_map(one_pixel(nan, nan, nan)).values == std::vector<std::uint8_t>{0, 0, 0});
  CHECK(tone_map(one_pixel(infinity, infinity, infinity)).values == std::vector<std::uint8_t>{255, 255, 255});
}
