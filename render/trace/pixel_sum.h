// What the paths of one pixel add up to, and how it becomes the pixel's values.
#pragma once

#include <algorithm>
#include <array>

#include "core/base/srgb.h"
#include "render/trace/path_trace.h"
#include "render/trace/path_wave.h"

namespace umax {

/// Paths of one pixel, summed in their order.
struct PixelSum {
  Eigen::Vector3d color{0, 0, 0}, color_squares{0, 0, 0}, half{0, 0, 0}, albedo{0, 0, 0}, normal{0, 0, 0};
  double depth = 0, squares = 0, luminances = 0;
  int num_met = 0, count = 0;

  void add(const PathResult& path, int sample) {
    const Eigen::Vector3d radiance = path.radiance.cast<double>();
    color += radiance;
    color_squares += radiance.cwiseProduct(radiance);
    if (sample % 2 == 0) half += radiance;
    albedo += path.albedo.cast<double>();
    normal += path.normal.cast<double>();
    const double light = double(luminance(path.radiance.x(), path.radiance.y(), path.radiance.z()));
    luminances += light;
    squares += light * light;
    depth += double(path.depth);
    num_met += path.depth > 0;
    ++count;
  }

  double mean_luminance() const { return luminances / count; }
  /// Variance of that mean, as the paths tell it; 0 for a single path.
  double variance_of_mean() const {
    const double mean = luminances / count;
    return count > 1 ? std::max(0.0, squares / count - mean * mean) / (count - 1) : 0;
  }
  /// The same of the mean of each colour.
  Eigen::Vector3d variance_of_color() const {
    const Eigen::Vector3d mean = color / count;
    if (count < 2) return {0, 0, 0};
    return (color_squares / count - mean.cwiseProduct(mean)).cwiseMax(0.0) / (count - 1);
  }
};

/// Puts the values of a pixel into the picture.
inline void store_pixel(const PixelSum& sum, TracedImage& image, int column, int row) {
  const auto store = [&](Image& to, const Eigen::Vector3d& value) {
    for (int c = 0; c < 3; ++c) to.pixel(column, row)[c] = float(value[c]);
  };
  const int samples = sum.count;
  store(image.color, sum.color / samples);
  if (image.has_color_noise()) store(image.color_variance, sum.variance_of_color());
  store(image.half, sum.half / ((samples + 1) / 2));
  store(image.albedo, sum.albedo / samples);
  store(image.normal, sum.normal / samples);
  *image.depth.pixel(column, row) = sum.num_met ? float(sum.depth / sum.num_met) : 0.0f;
  *image.variance.pixel(column, row) = float(sum.variance_of_mean());
  *image.samples.pixel(column, row) = float(samples);
  *image.alpha.pixel(column, row) = float(sum.num_met) / float(samples);
}

/// The same from two independent halves, each of which counts as much, however many paths it has: were they weighed by
/// their numbers, the half that happened to be dark would be taken for more than it is.
inline void store_pixel(const std::array<PixelSum, 2>& halves, TracedImage& image, int column, int row) {
  const PixelSum &a = halves[0], &b = halves[1];
  const auto store = [&](Image& to, const Eigen::Vector3d& value) {
    for (int c = 0; c < 3; ++c) to.pixel(column, row)[c] = float(value[c]);
  };
  store(image.color, (a.color / a.count + b.color / b.count) / 2);
  if (image.has_color_noise()) store(image.color_variance, (a.variance_of_color() + b.variance_of_color()) / 4);
  store(image.half, a.color / a.count);
  store(image.albedo, (a.albedo / a.count + b.albedo / b.count) / 2);
  store(image.normal, (a.normal / a.count + b.normal / b.count) / 2);
  const int num_met = a.num_met + b.num_met;
  *image.depth.pixel(column, row) = num_met ? float((a.depth + b.depth) / num_met) : 0.0f;
  *image.variance.pixel(column, row) = float((a.variance_of_mean() + b.variance_of_mean()) / 4);
  *image.samples.pixel(column, row) = float(a.count + b.count);
  *image.alpha.pixel(column, row) = float(0.5 * (double(a.num_met) / a.count + double(b.num_met) / b.count));
}

}  // namespace umax
