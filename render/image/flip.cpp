#include "render/image/flip.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/srgb.h"

namespace umax {
namespace {

using Eigen::Matrix3f;
using Plane = std::vector<float>;  // one value per pixel, rows from the top
using Planes = std::array<Plane, 3>;
using Kernel = std::vector<double>;  // taps -radius … radius

struct Size {
  int width = 0, height = 0;
  std::size_t count() const { return std::size_t(width) * std::size_t(height); }
};

/// Calls body(first, last) over blocks of rows or pixels; each element is written by one call only.
template <class Body>
void for_blocks(std::size_t count, std::size_t grain, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
}

// ---- colour spaces ----------------------------------------------------------------------------------------------

/// XYZ of Rec. 709 primaries whose sum is the white (0.31271, 0.32902).
Matrix3d make_xyz_from_rgb() {
  const auto xyz = [](double x, double y) { return Vector3d(x / y, 1, (1 - x - y) / y); };
  Matrix3d primaries;
  primaries << xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06);
  return primaries * Vector3d(primaries.inverse() * xyz(0.31271, 0.32902)).asDiagonal();
}

struct ColorSpaces {
  Matrix3f relative_from_rgb;  // XYZ divided by the white's
  Matrix3f rgb_from_relative;
};
const ColorSpaces& color_spaces() {
  static const ColorSpaces spaces = [] {
    const Matrix3d xyz_from_rgb = make_xyz_from_rgb();
    const Vector3d white = xyz_from_rgb * Vector3d::Ones();
    const Matrix3d relative = white.cwiseInverse().asDiagonal() * xyz_from_rgb;
    return ColorSpaces{relative.cast<float>(), Matrix3d(relative.inverse()).cast<float>()};
  }();
  return spaces;
}

/// (Y, Cx, Cz): CIELAB without its cube root, in which filtering is physical.
Vector3f opponent_from_relative(const Vector3f& r) {
  return {116 * r[1] - 16, 500 * (r[0] - r[1]), 200 * (r[1] - r[2])};
}
Vector3f relative_from_opponent(const Vector3f& o) {
  const float y = (o[0] + 16) / 116;
  return {y + o[1] / 500, y, y - o[2] / 200};
}

float lightness_curve(float t) {
  constexpr float delta = 6.0f / 29;
  return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
}

/// CIELAB with a and b scaled by 0.01 L: colour differences count less in the dark (Hunt effect).
Vector3f hunt_lab_from_rgb(const Vector3f& rgb) {
  const Vector3f r = color_spaces().relative_from_rgb * rgb;
  const float x = lightness_curve(r[0]), y = lightness_curve(r[1]), z = lightness_curve(r[2]);
  const float lightness = 116 * y - 16, scale = 0.01f * lightness;
  return {lightness, scale * 500 * (x - y), scale * 200 * (y - z)};
}

float hyab(const Vector3f& a, const Vector3f& b) {
  const Vector3f d = a - b;
  return std::abs(d[0]) + std::sqrt(d[1] * d[1] + d[2] * d[2]);
}

// ---- separable filters, edges repeated --------------------------------------------------------------------------

Kernel make_kernel(int radius, double (*value)(double, double), double parameter) {
  Kernel kernel;
  for (int x = -radius; x <= radius; ++x) kernel.push_back(value(x, parameter));
  return kernel;
}

/// Positive taps scaled to the sum 1, negative ones to -1.
Kernel normalised(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double tap : kernel) (tap > 0 ? positive : negative) += tap;
  for (double& tap : kernel) tap /= tap > 0 ? positive : -negative;
  return kernel;
}

Plane convolve_rows(const Plane& in, Size size, const Kernel& kernel) {
  const int radius = int(kernel.size() / 2);
  Plane out(in.size(), 0.0f);
  for_blocks(std::size_t(size.height), 8, [&](std::size_t first, std::size_t last) {
    Plane padded(std::size_t(size.width + 2 * radius));
    for (std::size_t y = first; y < last; ++y) {
      const float* row = &in[y * size.width];
      std::fill(padded.begin(), padded.begin() + radius, row[0]);
      std::copy(row, row + size.width, padded.begin() + radius);
      std::fill(padded.end() - radius, padded.end(), row[size.width - 1]);
      for (std::size_t k = 0; k < kernel.size(); ++k) {
        const float tap = float(kernel[kernel.size() - 1 - k]);
        for (int x = 0; x < size.width; ++x) out[y * size.width + x] += tap * padded[x + k];
      }
    }
  });
  return out;
}

Plane convolve_columns(const Plane& in, Size size, const Kernel& kernel) {
  const int radius = int(kernel.size() / 2);
  Plane out(in.size(), 0.0f);
  for_blocks(std::size_t(size.height), 8, [&](std::size_t first, std::size_t last) {
    for (std::size_t y = first; y < last; ++y) {
      for (int k = -radius; k <= radius; ++k) {
        const float tap = float(kernel[std::size_t(radius - k)]);
        const float* row = &in[std::size_t(std::clamp(int(y) + k, 0, size.height - 1)) * size.width];
        for (int x = 0; x < size.width; ++x) out[y * size.width + x] += tap * row[x];
      }
    }
  });
  return out;
}

// ---- colour difference ------------------------------------------------------------------------------------------

/// Gaussian of the contrast sensitivity, a sqrt(pi / b) exp(-pi^2 x^2 / b) with x in degrees.
struct Sensitivity {
  double amplitude, width;  // [-], [deg^2]
};
constexpr Sensitivity achromatic{1, 0.0047}, red_green{1, 0.0053}, blue_yellow[2] = {{34.1, 0.04}, {13.5, 0.025}};

double gaussian(double x, double sigma) {
  return std::exp(-x * x / (2 * sigma * sigma));
}

/// `in` filtered with a sum of Gaussians, normalised as a whole.
Plane filter_sensitivity(const Plane& in, Size size, const Sensitivity* terms, int num_terms,
                         double pixels_per_degree) {
  constexpr double pi = std::numbers::pi;
  const int radius = int(std::ceil(3 * std::sqrt(blue_yellow[0].width / (2 * pi * pi)) * pixels_per_degree));
  std::vector<Kernel> kernels;
  double total = 0;
  for (int i = 0; i < num_terms; ++i) {
    kernels.push_back(make_kernel(radius, gaussian, std::sqrt(terms[i].width / (2 * pi * pi)) * pixels_per_degree));
    double sum = 0;
    for (const double tap : kernels.back()) sum += tap;
    const double scale = terms[i].amplitude * std::sqrt(pi / terms[i].width);
    total += scale * sum * sum;
    for (double& tap : kernels.back()) tap *= std::sqrt(scale);
  }
  Plane out(in.size(), 0.0f);
  for (Kernel& kernel : kernels) {
    for (double& tap : kernel) tap /= std::sqrt(total);
    const Plane filtered = convolve_columns(convolve_rows(in, size, kernel), size, kernel);
    std::transform(out.begin(), out.end(), filtered.begin(), out.begin(), std::plus<>());
  }
  return out;
}

/// What the eye resolves of an opponent picture, as Hunt-adjusted CIELAB.
Planes perceived(const Planes& opponent, Size size, double pixels_per_degree) {
  Planes planes = {filter_sensitivity(opponent[0], size, &achromatic, 1, pixels_per_degree),
                   filter_sensitivity(opponent[1], size, &red_green, 1, pixels_per_degree),
                   filter_sensitivity(opponent[2], size, blue_yellow, 2, pixels_per_degree)};
  for_blocks(size.count(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const Vector3f relative = relative_from_opponent({planes[0][i], planes[1][i], planes[2][i]});
      const Vector3f rgb = (color_spaces().rgb_from_relative * relative).cwiseMax(0.0f).cwiseMin(1.0f);
      const Vector3f lab = hunt_lab_from_rgb(rgb);
      for (int c = 0; c < 3; ++c) planes[c][i] = lab[c];
    }
  });
  return planes;
}

/// Distances above 0.4 of the largest share the upper 0.05 of the scale.
float compressed(float distance, float largest) {
  constexpr float exponent = 0.7f, knee = 0.4f, knee_value = 0.95f;
  const float d = std::pow(distance, exponent), limit = knee * largest;
  return d < limit ? d * knee_value / limit : knee_value + (d - limit) / (largest - limit) * (1 - knee_value);
}

Plane color_difference(const Planes& reference, const Planes& test, Size size, double pixels_per_degree) {
  const Planes a = perceived(reference, size, pixels_per_degree), b = perceived(test, size, pixels_per_degree);
  const float largest = std::pow(hyab(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1})), 0.7f);
  Plane out(size.count());
  for_blocks(size.count(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      out[i] = compressed(hyab({a[0][i], a[1][i], a[2][i]}, {b[0][i], b[1][i], b[2][i]}), largest);
  });
  return out;
}

// ---- feature difference -----------------------------------------------------------------------------------------

struct Features {
  Plane edges, points;  // magnitudes of first and second derivatives
};

Plane magnitude(const Plane& x, const Plane& y) {
  Plane out(x.size());
  std::transform(x.begin(), x.end(), y.begin(), out.begin(), [](float a, float b) { return std::sqrt(a * a + b * b); });
  return out;
}

Features find_features(const Plane& lightness, Size size, double pixels_per_degree) {
  constexpr double detector_width = 0.082;  // [deg]
  const double sigma = 0.5 * detector_width * pixels_per_degree;
  const int radius = int(std::ceil(3 * sigma));
  const Kernel smooth = normalised(make_kernel(radius, gaussian, sigma));
  const Kernel edge = normalised(make_kernel(radius, [](double x, double s) { return -x * gaussian(x, s); }, sigma));
  const Kernel point =
      normalised(make_kernel(radius, [](double x, double s) { return (x * x / (s * s) - 1) * gaussian(x, s); }, sigma));
  const Plane along_x = convolve_rows(lightness, size, smooth), along_y = convolve_columns(lightness, size, smooth);
  return {magnitude(convolve_rows(along_y, size, edge), convolve_columns(along_x, size, edge)),
          magnitude(convolve_rows(along_y, size, point), convolve_columns(along_x, size, point))};
}

Plane feature_difference(const Planes& reference, const Planes& test, Size size, double pixels_per_degree) {
  const auto lightness = [](Plane y) {
    for (float& value : y) value = (value + 16) / 116;
    return y;
  };
  const Features a = find_features(lightness(reference[0]), size, pixels_per_degree);
  const Features b = find_features(lightness(test[0]), size, pixels_per_degree);
  Plane out(size.count());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float largest = std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
    out[i] = std::sqrt(std::min(largest / std::numbers::sqrt2_v<float>, 1.0f));
  }
  return out;
}

Planes opponent_planes(const Image& image, Size size) {
  Planes planes = {Plane(size.count()), Plane(size.count()), Plane(size.count())};
  for_blocks(size.count(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const float* pixel = &image.values[i * image.channels];
      Vector3f rgb;
      for (int c = 0; c < 3; ++c) rgb[c] = linear_from_srgb(std::clamp(pixel[image.channels >= 3 ? c : 0], 0.0f, 1.0f));
      const Vector3f opponent = opponent_from_relative(color_spaces().relative_from_rgb * rgb);
      for (int c = 0; c < 3; ++c) planes[c][i] = opponent[c];
    }
  });
  return planes;
}

Image unit_values(const Image8& image) {
  Image out(image.width, image.height, image.channels);
  std::transform(image.values.begin(), image.values.end(), out.values.begin(),
                 [](auto code) { return float(code) / 255; });
  return out;
}

std::string size_text(const Image& image) {
  return std::to_string(image.width) + "x" + std::to_string(image.height);
}

}  // namespace

FlipResult flip(const Image& reference, const Image& test, const FlipOptions& options) {
  if (reference.width != test.width || reference.height != test.height || reference.values.empty()) {
    throw Error(Fault::bad_data, {"compare", "the pictures must have one size",
                                  size_text(reference) + " and " + size_text(test), "render both alike"});
  }
  const Size size{reference.width, reference.height};
  const Planes a = opponent_planes(reference, size), b = opponent_planes(test, size);
  const Plane color = color_difference(a, b, size, options.pixels_per_degree);
  const Plane feature = feature_difference(a, b, size, options.pixels_per_degree);

  FlipResult result;
  result.map = Image(size.width, size.height, 1);
  std::size_t num_above = 0;
  for (std::size_t i = 0; i < size.count(); ++i) {
    const float value = std::pow(color[i], 1 - feature[i]);
    result.map.values[i] = value;
    result.mean += double(value);
    result.maximum = std::max(result.maximum, double(value));
    num_above += double(value) > options.threshold;
  }
  result.mean /= double(size.count());
  result.percent_above = 100.0 * double(num_above) / double(size.count());
  return result;
}

FlipResult flip(const Image8& reference, const Image8& test, const FlipOptions& options) {
  return flip(unit_values(reference), unit_values(test), options);
}

}  // namespace umax
