#include "render/trace/noisy_light.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/srgb.h"

namespace umax {
namespace {

float luminance_of(const float* p) {
  return luminance(p[0], p[1], p[2]);
}

// calls visit(value) for the 24 pixels around one, until it returns false
template <class Visit>
void for_each_around(const Plane& values, int width, int height, int x, int y, const Visit& visit) {
  for (int row = std::max(y - 2, 0); row <= std::min(y + 2, height - 1); ++row)
    for (int column = std::max(x - 2, 0); column <= std::min(x + 2, width - 1); ++column)
      if ((row != y || column != x) && !visit(values[std::size_t(row) * width + column])) return;
}

// whether three of the pixels around are about as bright: then it is no spark, and hardly any pixel is
bool has_equals(const Plane& light, int width, int height, int x, int y) {
  const float bright = light[std::size_t(y) * width + x] * (1 / 1.29f);
  int equals = 0;
  for_each_around(light, width, height, x, y, [&](float value) { return (equals += value >= bright) < 3; });
  return equals >= 3;
}

// third largest value among the 24 pixels around one
float third_around(const Plane& values, int width, int height, int x, int y) {
  float largest = 0, second = 0, third = 0;
  for_each_around(values, width, height, x, y, [&](float value) {
    const float below = std::min(value, largest), lower = std::min(below, second);
    largest = std::max(largest, value);
    second = std::max(second, below);
    third = std::max(third, lower);
    return true;
  });
  return third;
}

void scale_pixel(NoisyLight& noisy, std::size_t i, float scale) {
  for (auto* planes : {&noisy.light, &noisy.half})
    for (Plane& plane : *planes) plane[i] *= scale;
  noisy.of_paths[i] *= scale * scale;
  noisy.of_halves[i] *= scale * scale;
}

// One path that happens on a small bright light makes a spark that no mean of a window takes away. A pixel that stands
// out from all around it by no more than its own noise explains is lowered to them.
void lower_sparks(NoisyLight& noisy) {
  Plane light(noisy.size());
  parallel_blocks(Eigen::Index(noisy.size()), 8192, [&](Eigen::Index begin, Eigen::Index end) {
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
      light[i] = luminance(noisy.light[0][i], noisy.light[1][i], noisy.light[2][i]);
  });
  parallel_blocks(noisy.height, 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (int y = int(begin); y < int(end); ++y) {
      for (int x = 0; x < noisy.width; ++x) {
        const std::size_t i = std::size_t(y) * noisy.width + x;
        if (has_equals(light, noisy.width, noisy.height, x, y)) continue;
        const float around = third_around(light, noisy.width, noisy.height, x, y), excess = light[i] - around;
        if (!(excess > 0.3f * around) || !(excess * excess < 9 * noisy.of_paths[i])) continue;
        scale_pixel(noisy, i, around / light[i]);
      }
    }
  });
}

void divide_pixel(const TracedImage& traced, std::size_t i, NoisyLight& noisy) {
  const float* albedo = &traced.albedo.values[3 * i];
  for (int c = 0; c < 3; ++c) {
    const float divisor = std::max(albedo[c], least_albedo);
    noisy.light[c][i] = traced.color.values[3 * i + c] / divisor;
    noisy.half[c][i] = traced.half.values[3 * i + c] / divisor;
  }
  const float grey = std::max(luminance_of(albedo), least_albedo);
  const float all = luminance_of(&traced.color.values[3 * i]), half = luminance_of(&traced.half.values[3 * i]);
  noisy.of_paths[i] = traced.variance.values[i] / (grey * grey);
  noisy.of_halves[i] = (all - half) * (all - half) / (grey * grey);
  if (!traced.has_color_noise()) return;
  noisy.of_paths[i] = noisy.of_halves[i] = 0;
  for (int c = 0; c < 3; ++c) {
    const float divisor = std::max(albedo[c], least_albedo), apart = noisy.light[c][i] - noisy.half[c][i];
    noisy.of_paths[i] += traced.color_variance.values[3 * i + c] / (3 * divisor * divisor);
    noisy.of_halves[i] += apart * apart / 3;
  }
}

}  // namespace

NoisyLight empty_light(int width, int height) {
  NoisyLight noisy;
  noisy.width = width, noisy.height = height;
  for (auto* planes : {&noisy.light, &noisy.half})
    for (Plane& plane : *planes) plane.resize(noisy.size());
  noisy.of_paths.resize(noisy.size());
  noisy.of_halves.resize(noisy.size());
  return noisy;
}

NoisyLight noisy_light(const TracedImage& traced) {
  NoisyLight noisy = empty_light(traced.color.width, traced.color.height);
  parallel_blocks(Eigen::Index(noisy.size()), 8192, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) divide_pixel(traced, std::size_t(i), noisy);
  });
  lower_sparks(noisy);
  return noisy;
}

}  // namespace umax
