// Latitude-longitude pictures: row 0 is +Y, u = 0 looks along +Z, u = 0.25 along +X.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/image/image.h"

namespace umax {

inline Vector3f direction_of_latlong(float u, float v) {
  constexpr float pi = std::numbers::pi_v<float>;
  const float azimuth = 2 * pi * u, polar = pi * v;
  return {std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth)};
}

/// (u, v) in [0, 1] of a unit direction.
inline Vector2f latlong_of(const Vector3f& d) {
  constexpr float pi = std::numbers::pi_v<float>;
  const float u = std::atan2(d[0], d[2]) / (2 * pi);
  return {u < 0 ? u + 1 : u, std::acos(std::clamp(d[1], -1.0f, 1.0f)) / pi};
}

/// Bilinear look-up in a picture of 3 channels, wrapped around in u.
inline Vector3f look_up_latlong(const Image& image, const Vector2f& uv) {
  const float x = uv[0] * float(image.width) - 0.5f;
  const float y = std::clamp(uv[1] * float(image.height) - 0.5f, 0.0f, float(image.height - 1));
  const int x0 = int(std::floor(x)), y0 = int(y), y1 = std::min(y0 + 1, image.height - 1);
  const auto at = [&](int column, int row) -> Vector3f {
    return Eigen::Map<const Vector3f>(image.pixel((column + image.width) % image.width, row));
  };
  const float fx = x - float(x0), fy = y - float(y0);
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x0 + 1, y0)) + fy * ((1 - fx) * at(x0, y1) + fx * at(x0 + 1, y1));
}

}  // namespace umax
