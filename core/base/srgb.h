// The sRGB transfer curve (IEC 61966-2-1), the luminance weights of Rec. 709 and 8-bit codes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace umax {

/// Encoded value in [0, 1] for a linear one; values outside [0, 1] are continued by the curve, negative ones linearly.
/// Real: float, as in pictures, or double, as in mesh files and scenes. Both round as their own type does.
template <class Real>
Real srgb_from_linear(Real linear) {
  return linear <= Real(0.0031308) ? Real(12.92) * linear
                                   : Real(1.055) * std::pow(linear, Real(1) / Real(2.4)) - Real(0.055);
}

/// Linear value for an encoded one: the inverse of srgb_from_linear().
template <class Real>
Real linear_from_srgb(Real encoded) {
  return encoded <= Real(0.04045) ? encoded / Real(12.92) : std::pow((encoded + Real(0.055)) / Real(1.055), Real(2.4));
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
