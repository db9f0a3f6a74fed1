// The sRGB transfer curve (IEC 61966-2-1) and the luminance weights of Rec. 709.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace umax {

/// Encoded value in [0, 1] for a linear one; values outside [0, 1] are continued by the curve, negative ones linearly.
inline float srgb_from_linear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

/// Linear value for an encoded one: the inverse of srgb_from_linear().
inline float linear_from_srgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

/// Nearest 8-bit code of a value in [0, 1]; what lies outside is clipped, NaN gives 0.
inline std::uint8_t byte_from_unit(float value) {
  return value > 0 ? std::uint8_t(std::min(value, 1.0f) * 255.0f + 0.5f) : std::uint8_t(0);
}

/// Relative luminance of linear Rec. 709 values.
inline float luminance(float r, float g, float b) {
  return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

}  // namespace umax
