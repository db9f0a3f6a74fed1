// The light that reaches the surfaces of a noisy picture (colour over albedo), and what is known of its noise.
#pragma once

#include <array>
#include <vector>

#include "render/trace/path_trace.h"

namespace umax {

using Plane = std::vector<float>;  // a number for each pixel, row by row

inline constexpr float least_albedo = 0.02f;  // that light is divided by

struct NoisyLight {
  int width = 0, height = 0;
  std::array<Plane, 3> light, half;  // of all paths; of half of them, which know nothing of the others
  Plane
      of_paths;  // variance of the luminance of light, as the paths tell it; with color_variance, mean of the colours'
  Plane of_halves;  // squared difference of the luminances of light and half
  std::size_t size() const { return std::size_t(width) * height; }
};

/// Of a size, black and without noise.
NoisyLight empty_light(int width, int height);

/// Of a traced picture. Sparks (single paths that happened on a small bright light) are lowered to what is around them.
NoisyLight noisy_light(const TracedImage& traced);

}  // namespace umax
