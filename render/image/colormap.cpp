#include "render/image/colormap.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/srgb.h"

// Colours are laid out in OKLab (B. Ottosson, "A perceptual color space for image processing", 2020).
namespace umax {
namespace {

using Eigen::Matrix3f;

Vector3f linear_from_oklab(const Vector3f& lab) {
  Matrix3f cone_roots, rgb_from_cones;
  cone_roots << 1, 0.3963377774f, 0.2158037573f, 1, -0.1055613458f, -0.0638541728f, 1, -0.0894841775f, -1.2914855480f;
  rgb_from_cones << 4.0767416621f, -3.3077115913f, 0.2309699292f, -1.2684380046f, 2.6097574011f, -0.3413193965f,
      -0.0041960863f, -0.7034186147f, 1.7076147010f;
  const Vector3f roots = cone_roots * lab;
  return rgb_from_cones * roots.array().cube().matrix();
}

/// One colour of a ramp: hue in degrees and chroma; lightness runs evenly from the first to the last.
struct Stop {
  float chroma, hue;
};

/// Hue and chroma are blended smoothly between evenly spaced stops.
template <std::size_t N>
Vector3f ramp(const std::array<Stop, N>& stops, float darkest, float lightest, float value) {
  const float at = std::clamp(value, 0.0f, 1.0f) * float(N - 1);
  const std::size_t i = std::min(std::size_t(at), N - 2);
  const float s = at - float(i), blend = s * s * (3 - 2 * s);
  const float chroma = stops[i].chroma + blend * (stops[i + 1].chroma - stops[i].chroma);
  const float hue = (stops[i].hue + blend * (stops[i + 1].hue - stops[i].hue)) * 3.14159265f / 180;
  const float lightness = darkest + std::clamp(value, 0.0f, 1.0f) * (lightest - darkest);
  const Vector3f rgb = linear_from_oklab({lightness, chroma * std::cos(hue), chroma * std::sin(hue)});
  return rgb.cwiseMax(0.0f).cwiseMin(1.0f);
}

constexpr std::array<Stop, 5> cold_to_warm = {{{0.13f, 275}, {0.115f, 235}, {0.12f, 175}, {0.17f, 135}, {0.175f, 100}}};
constexpr std::array<Stop, 4> glow = {{{0.0f, 300}, {0.15f, 320}, {0.18f, 395}, {0.06f, 460}}};

Eigen::Matrix<std::uint8_t, 3, 1> codes(const Vector3f& linear) {
  return linear.unaryExpr([](float value) { return byte_from_unit(srgb_from_linear(value)); }).cast<std::uint8_t>();
}

}  // namespace

Vector3f color_of_value(double value) {
  if (std::isnan(value)) return {0.2f, 0.2f, 0.2f};
  if (value >= 1) return {0.70f, 0.010f, 0.025f};
  return ramp(cold_to_warm, 0.32f, 0.92f, float(value));
}

Eigen::Matrix<std::uint8_t, 3, 1> code_of_value(double value) {
  return codes(color_of_value(value));
}

Image8 difference_picture(const Image& map) {
  Image8 out(map.width, map.height, 3);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      Eigen::Map<Eigen::Matrix<std::uint8_t, 3, 1>>(out.pixel(x, y)) =
          codes(ramp(glow, 0.0f, 0.97f, map.pixel(x, y)[0]));
  return out;
}

}  // namespace umax
