#include "render/image/tone_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/base/srgb.h"

namespace umax {
namespace {

constexpr float mixing = 0.10f;     // share of the other channels that each receives before the curve
constexpr float mid_in = 0.18f;     // linear grey …
constexpr float mid_out = 0.19f;    // … and what the screen shows for it, linear too
constexpr float shoulder = 0.985f;  // d

/// y = x^a / (x^(a d) b + c) through (mid_in, mid_out) and (white, 1).
struct FilmicCurve {
  float a, b, c, white;

  FilmicCurve(float a_, float b_, float c_, float white_) : a(a_), b(b_), c(c_), white(white_) {}
  explicit FilmicCurve(const ToneMapOptions& options) : a(options.contrast), white(options.white) {
    const float d = shoulder;
    const float mid_a = std::pow(mid_in, a), mid_ad = std::pow(mid_in, a * d);
    const float white_a = std::pow(white, a), white_ad = std::pow(white, a * d);
    // two linear equations: mid_ad b + c = mid_a / mid_out, white_ad b + c = white_a
    b = (white_a - mid_a / mid_out) / (white_ad - mid_ad);
    c = white_a - white_ad * b;
  }
  float operator()(float x) const {
    if (!(x > 0)) return 0;
    if (x >= white) return 1;
    return std::pow(x, a) / (std::pow(x, a * shoulder) * b + c);
  }
};

/// Not-a-number and negative light count as none, infinite light as very much.
float finite_light(float value) {
  return value > 0 ? std::min(value, 1e6f) : 0.0f;
}

Vector3f mixed(const Vector3f& rgb, float share) {
  return rgb + share * (Vector3f::Constant(rgb.mean()) - rgb);
}

Vector3f filmic(const Vector3f& rgb, const FilmicCurve& curve, float saturation) {
  const Vector3f in = mixed(rgb.unaryExpr(&finite_light), mixing);
  const Vector3f shaped(curve(in[0]), curve(in[1]), curve(in[2]));
  const float grey = luminance(shaped[0], shaped[1], shaped[2]);
  // undo the mixing, but less and less towards white: highlights lose their colour as film does
  const float gain = saturation / (1 - mixing * (1 - grey));
  return Vector3f::Constant(grey) + gain * (shaped - Vector3f::Constant(grey));
}

}  // namespace

ShownLuminance::ShownLuminance(const ToneMapOptions& options)
    : options_(options), scale_(std::exp2(options.exposure_stops)) {
  const FilmicCurve curve(options);
  b_ = curve.b;
  c_ = curve.c;
}

float ShownLuminance::operator()(float luminance) const {
  const float light = finite_light(scale_ * luminance);
  if (options_.curve == ToneCurve::standard) return std::min(light, 1.0f);
  return FilmicCurve{options_.contrast, b_, c_, options_.white}(light);
}

Image8 tone_map(const Image& linear, const ToneMapOptions& options) {
  Image8 out(linear.width, linear.height, linear.channels);
  const FilmicCurve curve(options);
  const float exposure = std::exp2(options.exposure_stops);
  const int channels = linear.channels, num_colors = channels >= 3 ? 3 : 1;
  const auto show = [&](const float* in, std::uint8_t* shown) {
    Vector3f rgb = exposure * Vector3f(in[0], in[num_colors > 1 ? 1 : 0], in[num_colors > 1 ? 2 : 0]);
    if (options.curve == ToneCurve::filmic) rgb = filmic(rgb, curve, options.saturation);
    for (int c = 0; c < num_colors; ++c) shown[c] = byte_from_unit(srgb_from_linear(rgb[c]));
    if (channels == 4) shown[3] = byte_from_unit(in[3]);
  };
  tbb::parallel_for(tbb::blocked_range<int>(0, linear.height, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < linear.width; ++x) show(linear.pixel(x, y), out.pixel(x, y));
  });
  return out;
}

}  // namespace umax
