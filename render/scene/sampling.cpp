#include "render/scene/sampling.h"

#include <algorithm>
#include <bit>
#include <numbers>

namespace umax {
namespace {

// hash in which a bit depends on itself and lower bits only: on reversed bits this is an Owen scrambling
// [Laine, Karras 2011], constants of [Vegdahl 2021, "Building a better LK hash"]
std::uint32_t scramble_upwards(std::uint32_t v, std::uint32_t key) {
  v ^= v * 0x3d20adeau;
  v += key;
  v *= (key >> 16) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}

// Sobol's second dimension with reversed bits: Pascal's triangle modulo 2, a Kronecker power of [[1, 1], [0, 1]]
std::uint32_t pascal_product(std::uint32_t v) {
  v ^= (v >> 16) & 0x0000ffffu;
  v ^= (v >> 8) & 0x00ff00ffu;
  v ^= (v >> 4) & 0x0f0f0f0fu;
  v ^= (v >> 2) & 0x33333333u;
  return v ^ ((v >> 1) & 0x55555555u);
}

float unit_float(std::uint32_t v) {
  return float(int(v >> 8)) * 0x1p-24f;
}

std::uint32_t spread_bits(std::uint32_t v) {
  v &= 0xffffu;
  v = (v | (v << 8)) & 0x00ff00ffu;
  v = (v | (v << 4)) & 0x0f0f0f0fu;
  v = (v | (v << 2)) & 0x33333333u;
  return (v | (v << 1)) & 0x55555555u;
}

}  // namespace

SampleSequence::SampleSequence(int samples_per_pixel, unsigned seed)
    : log2_samples_(std::bit_width(unsigned(std::max(samples_per_pixel, 1) - 1))),
      log2_block_(std::min(16, (32 - log2_samples_) / 2)),
      seed_(hash_bits(seed + 0x9e3779b9u)) {
  std::uint32_t key = seed_;
  for (Keys& keys : keys_) {
    keys.shuffle = hash_bits(key += 0x9e3779b9u);
    keys.first = hash_bits(key += 0x9e3779b9u);
    keys.second = hash_bits(key += 0x9e3779b9u);
  }
}

std::uint32_t SampleSequence::pixel_start(int x, int y) const {
  const std::uint32_t mask = (1u << log2_block_) - 1;
  const std::uint32_t morton = spread_bits(std::uint32_t(x) & mask) | (spread_bits(std::uint32_t(y) & mask) << 1);
  return morton << log2_samples_;
}

std::uint32_t SampleSequence::block_key(int x, int y) const {
  const std::uint32_t column = std::uint32_t(x) >> log2_block_, row = std::uint32_t(y) >> log2_block_;
  return column == 0 && row == 0 ? 0 : hash_bits(seed_ ^ hash_bits(column + 0x10001u * row));
}

std::uint32_t SampleSequence::stream_key(int stream) {
  return stream == 0 ? 0 : hash_bits(0x632be5abu * std::uint32_t(stream));
}

Vector2f SampleSequence::point_reversed(std::uint32_t reversed_index, int dimension, std::uint32_t block_key) const {
  Vector2f point;
  points(&reversed_index, &block_key, 1, dimension, &point.x(), &point.y());
  return point;
}

void SampleSequence::points(const std::uint32_t* reversed_indices, const std::uint32_t* block_keys, int count,
                            int dimension, float* u, float* v) const {
  const Keys keys = keys_[dimension % max_dimensions];
  for (int i = 0; i < count; ++i) {
    const std::uint32_t block = block_keys[i];
    const std::uint32_t shuffled = reverse_bits(scramble_upwards(reversed_indices[i], keys.shuffle ^ block));
    u[i] = unit_float(reverse_bits(scramble_upwards(shuffled, keys.first ^ block)));
    v[i] = unit_float(reverse_bits(scramble_upwards(pascal_product(shuffled), keys.second ^ block)));
  }
}

TableDistribution::TableDistribution(int width, int height, const std::vector<float>& values)
    : width_(width),
      height_(height),
      row_sums_(std::size_t(height) + 1, 0.0f),
      cell_sums_(std::size_t(height) * (width + 1), 0.0f) {
  std::vector<double> rows(height);
  double total = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) rows[y] += double(values[std::size_t(y) * width + x]);
    total += rows[y];
  }
  double above = 0;
  for (int y = 0; y < height; ++y) {
    above += total > 0 ? rows[y] / total : 1.0 / height;
    row_sums_[y + 1] = float(above);
    float* cells = &cell_sums_[std::size_t(y) * (width + 1)];
    double left = 0;
    for (int x = 0; x < width; ++x) {
      left += rows[y] > 0 ? double(values[std::size_t(y) * width + x]) / rows[y] : 1.0 / width;
      cells[x + 1] = float(left);
    }
    cells[width] = 1;
  }
  row_sums_[height] = 1;
}

namespace {

// interval of a cumulative table that holds u, and u's place inside it
int find_interval(const float* sums, int count, float u, float& inside) {
  const auto upper = std::upper_bound(sums + 1, sums + count, u);
  const int i = int(upper - sums) - 1;
  const float width = sums[i + 1] - sums[i];
  inside = width > 0 ? std::clamp((u - sums[i]) / width, 0.0f, 0.99999994f) : 0.5f;
  return i;
}

}  // namespace

Vector2f TableDistribution::sample(const Vector2f& u, float& density) const {
  float in_x = 0, in_y = 0;
  const int y = find_interval(row_sums_.data(), height_, u.y(), in_y);
  const float* cells = &cell_sums_[std::size_t(y) * (width_ + 1)];
  const int x = find_interval(cells, width_, u.x(), in_x);
  density = (row_sums_[y + 1] - row_sums_[y]) * (cells[x + 1] - cells[x]) * float(width_) * float(height_);
  return {(float(x) + in_x) / float(width_), (float(y) + in_y) / float(height_)};
}

float TableDistribution::density(const Vector2f& point) const {
  const int x = std::clamp(int(point.x() * float(width_)), 0, width_ - 1);
  const int y = std::clamp(int(point.y() * float(height_)), 0, height_ - 1);
  const float* cells = &cell_sums_[std::size_t(y) * (width_ + 1)];
  return (row_sums_[y + 1] - row_sums_[y]) * (cells[x + 1] - cells[x]) * float(width_) * float(height_);
}

PixelFilter::PixelFilter() {
  constexpr double width = 3, pi = std::numbers::pi;
  // integral of the window over t in [0, 1], from its cosine series
  const auto integral = [](double t) {
    return 0.35875 * t - 0.48829 * std::sin(2 * pi * t) / (2 * pi) + 0.14128 * std::sin(4 * pi * t) / (4 * pi) -
           0.01168 * std::sin(6 * pi * t) / (6 * pi);
  };
  double t = 0;
  for (int i = 0; i < num_entries; ++i) {
    const double target = integral(1) * i / (num_entries - 1);
    double low = t, high = 1;
    for (int step = 0; step < 24; ++step) (integral((low + high) / 2) < target ? low : high) = (low + high) / 2;
    t = low;
    inverse_[i] = float(width * ((low + high) / 2 - 0.5));
  }
  inverse_[num_entries] = inverse_[num_entries - 1];
}

const PixelFilter& pixel_filter() {
  static const PixelFilter filter;
  return filter;
}

}  // namespace umax
