#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <random>

#include "core/base/srgb.h"
#include "core/base/types.h"
#include "render/image/srgb_code.h"
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

/// What the head of tone_map.h says, by the C library's powers, of light that is a number.
std::array<int, 3> shown_by_formula(const Vector3f& light, const ToneMapOptions& options) {
  constexpr float mixing = 0.10f, d = 0.985f, mid_in = 0.18f, mid_out = 0.19f;
  const float a = options.contrast, mid_a = std::pow(mid_in, a), mid_ad = std::pow(mid_in, a * d);
  const float white_a = std::pow(options.white, a), white_ad = std::pow(options.white, a * d);
  const float b = (white_a - mid_a / mid_out) / (white_ad - mid_ad), c = white_a - white_ad * b;
  const Vector3f in = light.cwiseMax(0.0f), mixed = in + mixing * (Vector3f::Constant(in.mean()) - in);
  const Vector3f shaped = mixed.unaryExpr([&](float x) {
    if (x <= 0) return 0.0f;
    return x >= options.white ? 1.0f : std::pow(x, a) / (std::pow(x, a * d) * b + c);
  });
  const float grey = luminance(shaped[0], shaped[1], shaped[2]);
  const float gain = options.saturation / (1 - mixing * (1 - grey));
  const Vector3f shown = Vector3f::Constant(grey) + gain * (shaped - Vector3f::Constant(grey));
  std::array<int, 3> codes{};
  for (int k = 0; k < 3; ++k) codes[std::size_t(k)] = byte_from_unit(srgb_from_linear(shown[k]));
  return codes;
}

/// Light from 2^-16 to 2^6, as often in every doubling, and some of it black.
Image random_light(int width, int height) {
  Image image(width, height, 3);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> stops(-16, 6);
  for (float& value : image.values) value = random() % 64 == 0 ? 0.0f : std::exp2(stops(random));
  return image;
}

int num_other_than_by_formula(const Image& light, const ToneMapOptions& options) {
  const Image8 shown = tone_map(light, options);
  int num_others = 0;
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x) {
      const float* in = light.pixel(x, y);
      const std::array<int, 3> expected = shown_by_formula({in[0], in[1], in[2]}, options);
      for (int c = 0; c < 3; ++c) num_others += shown.pixel(x, y)[c] != expected[std::size_t(c)];
    }
  return num_others;
}

}  // namespace

TEST_CASE("every code of a picture is the one that the formula gives, however its powers are taken") {
  const Image light = random_light(517, 401);
  CHECK(num_other_than_by_formula(light, {}) == 0);
  CHECK(num_other_than_by_formula(light, {.contrast = 2, .white = 64, .saturation = 1.4f}) == 0);
  CHECK(num_other_than_by_formula(light, {.contrast = 3, .white = 100}) == 0);
}

TEST_CASE("a table gives the codes of the sRGB curve, on both sides of where each begins") {
  const SrgbCodes codes;
  const auto code = [](float linear) { return int(byte_from_unit(srgb_from_linear(linear))); };
  int num_others = 0;
  for (int k = 0; k < 255; ++k) {
    float value = linear_from_srgb((float(k) + 0.5f) / 255);
    for (int i = 0; i < 200; ++i) value = std::nextafter(value, 0.0f);
    for (int i = 0; i < 400; ++i, value = std::nextafter(value, 1.0f)) num_others += codes(value) != code(value);
  }
  for (int i = -100; i < 20000; ++i) num_others += codes(float(i) / 16384) != code(float(i) / 16384);
  CHECK(num_others == 0);
  CHECK(codes(std::nanf("")) == 0);
  CHECK(codes(INFINITY) == 255);
}

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
