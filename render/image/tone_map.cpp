#include "render/image/tone_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/base/srgb.h"
#include "render/image/srgb_code.h"

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

// log2(x) for x > 0 that is no denormal, to 2e-7 of the result and 1e-7; without branches
inline float quick_log2(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // the rest lies in [sqrt(1/2), sqrt(2))
  const float rest = std::bit_cast<float>(bits - (exponent << 23));
  const float t = (rest - 1) / (rest + 1), s = t * t;
  return float(exponent) + t * (2.88539008f + s * (0.96179669f + s * (0.57707802f + s * 0.41219858f)));
}

// 2^x for |x| < 126, to 3e-7 of it; without branches
inline float quick_exp2(float x) {
  const float whole = std::nearbyint(x), f = x - whole;
  const float power =
      1 + f * (0.69314718f +
               f * (0.24022651f + f * (0.05550411f + f * (0.00961813f + f * (0.00133336f + f * 0.00015404f)))));
  return std::bit_cast<float>((int(whole) + 127) << 23) * power;
}

/// Pixels side by side. Powers are taken by short polynomials, in a form that compilers turn into vector code; where
/// that may lead to another code than the C library's powers they are asked.
class Shower {
 public:
  static constexpr int most_pixels = 64;

  explicit Shower(const ToneMapOptions& options)
      : options_(options), curve_(options), exposure_(std::exp2(options.exposure_stops)) {}

  void show(const float* linear, int count, int channels, std::uint8_t* shown) const {
    Rows rows;
    const int num_colors = channels >= 3 ? 3 : 1;
    for (int i = 0; i < count; ++i)
      for (int c = 0; c < 3; ++c) rows[c][i] = exposure_ * linear[i * channels + std::min(c, num_colors - 1)];
    const bool is_filmic = options_.curve == ToneCurve::filmic;
    const bool is_quick = is_filmic && options_.contrast <= most_quick_contrast && options_.white <= most_quick_white;
    Row uncertainty{};
    Rows in = rows;
    if (is_quick) shape(rows, count, uncertainty);
    for (int i = 0; i < count; ++i) {
      Vector3f rgb(rows[0][i], rows[1][i], rows[2][i]);
      const auto is_certain = [&](float value) {
        return codes()(value - uncertainty[i]) == codes()(value + uncertainty[i]);
      };
      if (is_filmic && !(is_quick && is_certain(rgb[0]) && is_certain(rgb[1]) && is_certain(rgb[2])))
        rgb = filmic(Vector3f(in[0][i], in[1][i], in[2][i]), curve_, options_.saturation);
      for (int c = 0; c < num_colors; ++c) shown[i * channels + c] = codes()(rgb[c]);
      if (channels == 4) shown[i * channels + 3] = byte_from_unit(linear[i * channels + 3]);
    }
  }

 private:
  using Row = std::array<float, most_pixels>;
  using Rows = std::array<Row, 3>;

  // within these the polynomials' error stays below a third of the share of the largest colour that is taken for uncertain
  static constexpr float most_quick_contrast = 2, most_quick_white = 64, uncertain_share = 5e-6f;

  static const SrgbCodes& codes() {
    static const SrgbCodes codes;
    return codes;
  }

  // filmic() in place
  void shape(Rows& rows, int count, Row& uncertainty) const {
    Row &r = rows[0], &g = rows[1], &b = rows[2];
    for (int i = 0; i < count; ++i) {
      const float in_r = finite_light(r[i]), in_g = finite_light(g[i]), in_b = finite_light(b[i]);
      const float mean = (in_r + in_g + in_b) * (1.0f / 3);
      const float out_r = quick_curve(in_r + mixing * (mean - in_r)),
                  out_g = quick_curve(in_g + mixing * (mean - in_g)),
                  out_b = quick_curve(in_b + mixing * (mean - in_b));
      const float grey = luminance(out_r, out_g, out_b);
      const float gain = options_.saturation / (1 - mixing * (1 - grey));
      r[i] = grey + gain * (out_r - grey), g[i] = grey + gain * (out_g - grey), b[i] = grey + gain * (out_b - grey);
      uncertainty[i] = uncertain_share * std::max(std::max(out_r, out_g), out_b);
    }
  }

  float quick_curve(float x) const {
    constexpr float darkest = 1e-12f;
    const float log = curve_.a * quick_log2(x > darkest ? x : darkest);
    const float shaped = quick_exp2(log) / (quick_exp2(shoulder * log) * curve_.b + curve_.c);
    return x >= curve_.white ? 1.0f : x > darkest ? shaped : 0.0f;
  }

  ToneMapOptions options_;
  FilmicCurve curve_;
  float exposure_;
};

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
  const Shower shower(options);
  tbb::parallel_for(tbb::blocked_range<int>(0, linear.height, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < linear.width; x += Shower::most_pixels)
        shower.show(linear.pixel(x, y), std::min(Shower::most_pixels, linear.width - x), linear.channels,
                    out.pixel(x, y));
  });
  return out;
}

}  // namespace umax
