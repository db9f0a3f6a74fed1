// Sample points and the maps from the unit square that the path tracer draws with.
//
// Points: Sobol's first two dimensions, Owen-scrambled by hashing and shuffled anew for every pair of dimensions
// [Burley 2020, "Practical hash-based Owen scrambling"]. One sequence serves the whole picture, its index running along
// a Morton curve through the pixels, so that neighbours get complementary points and the error looks like blue noise
// [Ahmed, Wonka 2020, "Screen-space blue-noise diffusion of Monte Carlo sampling error"].
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/image/image.h"
#include "render/scene/fast_math.h"

namespace umax {

inline std::uint32_t reverse_bits(std::uint32_t v) {
  v = __builtin_bswap32(v);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

/// Scrambling keys of one picture; shared by all pixels. Depends on seed and number of samples only.
class SampleSequence {
 public:
  static constexpr int max_dimensions = 128;  // pairs; deeper ones start over

  SampleSequence(int samples_per_pixel, unsigned seed);

  /// First index of a pixel's own run of points.
  std::uint32_t pixel_start(int x, int y) const;
  /// Key that tells blocks of pixels apart where the index has no room for the whole picture.
  std::uint32_t block_key(int x, int y) const;
  /// Added to it by exclusive or, makes another sequence that knows nothing of the first; of stream 0 it is 0.
  static std::uint32_t stream_key(int stream);
  /// The point [0, 1)^2 of a pair of dimensions at an index of the sequence.
  Vector2f point(std::uint32_t index, int dimension, std::uint32_t block_key) const {
    return point_reversed(reverse_bits(index), dimension, block_key);
  }
  /// The same from the index with its bits reversed.
  Vector2f point_reversed(std::uint32_t reversed_index, int dimension, std::uint32_t block_key) const;
  /// The same for many indices at once: row u and row v of their points, `count` each.
  void points(const std::uint32_t* reversed_indices, const std::uint32_t* block_keys, int count, int dimension,
              float* u, float* v) const;

 private:
  struct Keys {
    std::uint32_t shuffle, first, second;
  };
  int log2_samples_, log2_block_;
  unsigned seed_;
  std::array<Keys, max_dimensions> keys_;
};

/// Well mixed 32-bit hash.
inline std::uint32_t hash_bits(std::uint32_t value) {
  value ^= value >> 16;
  value *= 0x7feb352du;
  value ^= value >> 15;
  value *= 0x846ca68bu;
  return value ^ (value >> 16);
}

/// Uniform square to uniform unit disc, keeping neighbours together [Shirley, Chiu 1997].
inline Vector2f disc_from_square(const Vector2f& u) {
  const float a = 2 * u.x() - 1, b = 2 * u.y() - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr float quarter_pi = 0.78539816f;
  if (std::abs(a) > std::abs(b)) {
    const SinCos angle = sin_cos_quarter(quarter_pi * (b / a));
    return {a * angle.cosine, a * angle.sine};
  }
  const SinCos angle = sin_cos_quarter(quarter_pi * (a / b));
  return {b * angle.sine, b * angle.cosine};
}

/// Uniform square to the hemisphere about +z with density cos / pi.
inline Vector3f cosine_hemisphere(const Vector2f& u) {
  const Vector2f disc = disc_from_square(u);
  const float z2 = 1 - disc.x() * disc.x() - disc.y() * disc.y();
  return {disc.x(), disc.y(), std::sqrt(z2 > 1e-12f ? z2 : 1e-12f)};
}

/// Two unit vectors that complete a unit vector to a right-handed frame [Duff et al. 2017].
struct Frame {
  Vector3f x, y, z;
  explicit Frame(const Vector3f& normal) : z(normal) {
    const float sign = std::copysign(1.0f, normal.z());
    const float a = -1.0f / (sign + normal.z()), b = normal.x() * normal.y() * a;
    x = Vector3f(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
    y = Vector3f(b, sign + normal.y() * normal.y() * a, -normal.y());
  }
  Vector3f to_local(const Vector3f& v) const { return {v.dot(x), v.dot(y), v.dot(z)}; }
  Vector3f to_world(const Vector3f& v) const { return v.x() * x + v.y() * y + v.z() * z; }
};

/// Piecewise constant density over the unit square, proportional to a table of values.
class TableDistribution {
 public:
  TableDistribution() = default;
  /// values: height rows of width, not negative; all zero gives the uniform density.
  TableDistribution(int width, int height, const std::vector<float>& values);
  /// Point of the square for a uniform one; density receives its probability density there.
  Vector2f sample(const Vector2f& u, float& density) const;
  float density(const Vector2f& point) const;
  bool empty() const { return width_ == 0; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<float> row_sums_;   // cumulative over rows, height + 1
  std::vector<float> cell_sums_;  // cumulative inside each row, width + 1 each
};

/// Offset from the pixel's centre [px] with the density of a Blackman-Harris window of full width 3 px.
class PixelFilter {
 public:
  PixelFilter();
  Vector2f offset(const Vector2f& u) const { return {offset_1d(u.x()), offset_1d(u.y())}; }

 private:
  float offset_1d(float u) const {
    const float position = u * (num_entries - 1);
    const int i = int(position);
    return inverse_[i] + (position - float(i)) * (inverse_[i + 1] - inverse_[i]);
  }
  static constexpr int num_entries = 1025;
  std::array<float, num_entries + 1> inverse_;
};

/// The one filter of all pictures: its table takes longer than a small picture.
const PixelFilter& pixel_filter();

}  // namespace umax
