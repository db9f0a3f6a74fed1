// Pictures in memory: 32-bit float, scene-linear Rec. 709, rows from the top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace umax {

using Eigen::Vector2f;
using Eigen::Vector3f;

struct Image {
  int width = 0, height = 0, channels = 3;
  std::vector<float> values;  // (y * width + x) * channels + c

  Image() = default;
  Image(int width_, int height_, int channels_ = 3)
      : width(width_), height(height_), channels(channels_), values(std::size_t(width_) * height_ * channels_, 0.0f) {}
  float* pixel(int x, int y) { return values.data() + (std::size_t(y) * width + x) * channels; }
  const float* pixel(int x, int y) const { return values.data() + (std::size_t(y) * width + x) * channels; }
};

/// A picture as it is shown: 8-bit sRGB (or grey), rows from the top. channels: 1, 3 or 4 (alpha last, straight).
struct Image8 {
  int width = 0, height = 0, channels = 3;
  std::vector<std::uint8_t> values;  // (y * width + x) * channels + c

  Image8() = default;
  Image8(int width_, int height_, int channels_ = 3)
      : width(width_), height(height_), channels(channels_), values(std::size_t(width_) * height_ * channels_, 0) {}
  std::uint8_t* pixel(int x, int y) { return values.data() + (std::size_t(y) * width + x) * channels; }
  const std::uint8_t* pixel(int x, int y) const { return values.data() + (std::size_t(y) * width + x) * channels; }
};

/// A named group of channels of one frame, for layered EXR: "" colour (RGB or RGBA), "Albedo", "N", "Z", "variance".
struct Layer {
  std::string name;
  Image image;
};

}  // namespace umax
