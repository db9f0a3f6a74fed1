// Non-local means on the light that reaches the surfaces (colour over albedo) [Buades et al. 2005; Rousselle, Knaus,
// Zwicker 2012, 2013]: a pixel becomes the weighted mean of its window, the weights falling with the distance of small
// patches, measured in units of their noise, and with the distance of normals and of depth from the tangent plane.
#include "render/trace/denoise.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr int tile_size = 64;    // [px]
constexpr int most_radius = 7;   // [px] of the window that a pixel draws from
constexpr int patch_radius = 2;  // [px]
constexpr float normal_tolerance = 0.10f;
constexpr float albedo_tolerance = 0.10f;
constexpr float depth_tolerance = 0.01f;  // of the depth itself
constexpr float color_tolerance = 0.45f;  // in standard deviations of a patch's noise

// the picture as planes of one size
struct Planes {
  int width = 0, height = 0;
  std::array<Plane, 3> light;  // colour over albedo
  std::array<Plane, 3> normal, albedo;
  Plane variance;                 // of light
  Plane depth, slope_x, slope_y;  // [m], [m/px]

  explicit Planes(const Image& image) : width(image.width), height(image.height) {
    for (auto* planes : {&light, &normal, &albedo})
      for (Plane& plane : *planes) plane.resize(size());
    for (Plane* plane : {&variance, &depth, &slope_x, &slope_y}) plane->resize(size());
  }
  std::size_t size() const { return std::size_t(width) * height; }
};

// mean over a square of (2 radius + 1)^2 pixels, smaller at the border
Plane box_mean(const Plane& in, int width, int height, int radius) {
  Plane rows(in.size()), out(in.size());
  parallel_blocks(height, 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index y = begin; y < end; ++y) {
      double sum = 0;
      const float* row = &in[y * width];
      for (int x = 0; x < std::min(radius, width); ++x) sum += double(row[x]);
      for (int x = 0; x < width; ++x) {
        if (x + radius < width) sum += double(row[x + radius]);
        if (x - radius - 1 >= 0) sum -= double(row[x - radius - 1]);
        rows[y * width + x] = float(sum / (std::min(x + radius, width - 1) - std::max(x - radius, 0) + 1));
      }
    }
  });
  parallel_blocks(width, 64, [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<double> sums(end - begin, 0.0);
    const auto add = [&](int y, double sign) {
      for (Eigen::Index x = begin; x < end; ++x) sums[x - begin] += sign * double(rows[std::size_t(y) * width + x]);
    };
    for (int y = 0; y < std::min(radius, height); ++y) add(y, 1);
    for (int y = 0; y < height; ++y) {
      if (y + radius < height) add(y + radius, 1);
      if (y - radius - 1 >= 0) add(y - radius - 1, -1);
      const double count = std::min(y + radius, height - 1) - std::max(y - radius, 0) + 1;
      for (Eigen::Index x = begin; x < end; ++x) out[std::size_t(y) * width + x] = float(sums[x - begin] / count);
    }
  });
  return out;
}

// The paths' own variance overstates the noise of well spread samples. The two halves of the paths tell by how much,
// pixel by pixel too noisily, over a neighbourhood well [Rousselle et al. 2012].
void estimate_variance(const NoisyLight& noise, Planes& planes) {
  const Plane paths_near = box_mean(noise.of_paths, planes.width, planes.height, 1);
  const Plane paths_around = box_mean(noise.of_paths, planes.width, planes.height, 8);
  const Plane halves_around = box_mean(noise.of_halves, planes.width, planes.height, 8);
  parallel_blocks(Eigen::Index(planes.size()), 8192, [&](Eigen::Index begin, Eigen::Index end) {
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
      const float ratio = paths_around[i] > 0 ? std::clamp(halves_around[i] / paths_around[i], 0.02f, 1.5f) : 1.0f;
      planes.variance[i] = paths_near[i] * ratio;
    }
  });
}

// the smaller of two one-sided differences: at an edge, the one that stays on the surface
float one_sided(float before, float here, float after) {
  const float a = here - before, b = after - here;
  return std::abs(a) < std::abs(b) ? a : b;
}

void fill_slopes(Planes& p, int y) {
  for (int x = 0; x < p.width; ++x) {
    const std::size_t i = std::size_t(y) * p.width + x;
    const auto at = [&](int column, int row) {
      return p.depth[std::size_t(std::clamp(row, 0, p.height - 1)) * p.width + std::clamp(column, 0, p.width - 1)];
    };
    p.slope_x[i] = one_sided(at(x - 1, y), p.depth[i], at(x + 1, y));
    p.slope_y[i] = one_sided(at(x, y - 1), p.depth[i], at(x, y + 1));
  }
}

Planes split(const TracedImage& guides, const NoisyLight& light) {
  Planes planes(guides.albedo);
  planes.light = light.light;
  planes.depth = guides.depth.values;
  estimate_variance(light, planes);
  parallel_blocks(planes.height, 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (std::size_t i = std::size_t(begin) * planes.width; i < std::size_t(end) * planes.width; ++i)
      for (int c = 0; c < 3; ++c) {
        planes.albedo[c][i] = guides.albedo.values[3 * i + c];
        planes.normal[c][i] = guides.normal.values[3 * i + c];
      }
    for (Eigen::Index y = begin; y < end; ++y) fill_slopes(planes, int(y));
  });
  return planes;
}

// exp(-x) for x >= 0, to 2e-4, in a form that compilers turn into vector code
float falling_exponential(float x) {
  const float t = std::min(x * 1.44269504f, 120.0f);
  const int whole = int(t);
  const float f = float(whole) - t;  // (-1, 0]
  const float power = 1 + f * (0.69314718f + f * (0.24022651f + f * (0.05550411f + f * 0.00961813f)));
  return std::bit_cast<float>((127 - whole) << 23) * power;
}

// One tile with a border for window and patches, in buffers of its own.
class Tile {
 public:
  Tile(const Planes& planes, int left, int top, float noise_scale, int radius)
      : radius_(std::min(radius, most_radius)) {
    for (int c = 0; c < 3; ++c) {
      cut(planes, planes.light[c], left, top, light_[c]);
      cut(planes, planes.normal[c], left, top, normal_[c]);
      cut(planes, planes.albedo[c], left, top, albedo_[c]);
    }
    cut(planes, planes.variance, left, top, variance_);
    for (float& v : variance_) v *= noise_scale;
    cut(planes, planes.depth, left, top, depth_);
    cut(planes, planes.slope_x, left, top, slope_x_);
    cut(planes, planes.slope_y, left, top, slope_y_);
    for (Plane& sum : sums_) sum.assign(tile_size * tile_size, 0.0f);
    weights_.assign(tile_size * tile_size, 0.0f);
  }

  void filter() {
    if (is_clean()) return keep();
    for (int dy = -radius_; dy <= radius_; ++dy)
      for (int dx = -radius_; dx <= radius_; ++dx) add_offset(dx, dy);
  }

  float value(int c, int x, int y) const { return sums_[c][y * tile_size + x] / weights_[y * tile_size + x]; }

 private:
  /// Whether nothing tells that any of its pixels is noisy.
  bool is_clean() const {
    for (int y = border_; y < border_ + tile_size; ++y)
      for (int x = border_; x < border_ + tile_size; ++x)
        if (variance_[std::size_t(y) * stride_ + x] > 0) return false;
    return true;
  }
  void keep() {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < tile_size; ++y)
        std::copy_n(&light_[c][std::size_t(y + border_) * stride_ + border_], tile_size,
                    &sums_[c][std::size_t(y) * tile_size]);
    weights_.assign(weights_.size(), 1.0f);
  }

  void cut(const Planes& planes, const Plane& from, int left, int top, Plane& to) const {
    to.resize(std::size_t(stride_) * stride_);
    for (int y = 0; y < stride_; ++y) {
      const int row = std::clamp(top + y - border_, 0, planes.height - 1);
      for (int x = 0; x < stride_; ++x) {
        const int column = std::clamp(left + x - border_, 0, planes.width - 1);
        to[std::size_t(y) * stride_ + x] = from[std::size_t(row) * planes.width + column];
      }
    }
  }

  // adds to every pixel of the tile its neighbour at one offset
  void add_offset(int dx, int dy) {
    const int shift = dy * stride_ + dx;
    for (int y = 0; y < rows_; ++y) patch_row(y, shift);
    for (int y = 0; y < tile_size; ++y) weigh_row(y, dx, dy);
  }

  // distances of single pixels in units of their noise, summed along the row
  void patch_row(int y, int shift) {
    std::array<float, rows_> distance;
    const std::size_t start = std::size_t(y + border_ - patch_radius) * stride_ + border_ - patch_radius;
    const float *r = &light_[0][start], *g = &light_[1][start], *b = &light_[2][start], *v = &variance_[start];
    for (int x = 0; x < rows_; ++x) {
      const float dr = r[x] - r[x + shift], dg = g[x] - g[x + shift], db = b[x] - b[x + shift];
      const float here = v[x], there = v[x + shift];
      const float squares = (dr * dr + dg * dg + db * db) * (1.0f / 3);
      distance[x] = (squares - (here + std::min(here, there))) / (1e-7f + tolerance2_ * (here + there));
    }
    float* sums = &patch_[std::size_t(y) * tile_size];
    for (int x = 0; x < tile_size; ++x)
      sums[x] = distance[x] + distance[x + 1] + distance[x + 2] + distance[x + 3] + distance[x + 4];
  }

  void weigh_row(int y, int dx, int dy) {
    constexpr float patch_share = 1.0f / ((2 * patch_radius + 1) * (2 * patch_radius + 1));
    constexpr float normal_scale = 1 / (normal_tolerance * normal_tolerance);
    constexpr float albedo_scale = 1 / (albedo_tolerance * albedo_tolerance);
    const std::size_t start = std::size_t(y + border_) * stride_ + border_;
    const int shift = dy * stride_ + dx;
    const float *p0 = &patch_[std::size_t(y) * tile_size], *p1 = p0 + tile_size, *p2 = p1 + tile_size,
                *p3 = p2 + tile_size, *p4 = p3 + tile_size;
    const float *nx = &normal_[0][start], *ny = &normal_[1][start], *nz = &normal_[2][start];
    const float *ar = &albedo_[0][start], *ag = &albedo_[1][start], *ab = &albedo_[2][start];
    const float *z = &depth_[start], *sx = &slope_x_[start], *sy = &slope_y_[start];
    std::array<float, tile_size> weight;
    for (int x = 0; x < tile_size; ++x) {
      const float color = (p0[x] + p1[x] + p2[x] + p3[x] + p4[x]) * patch_share;
      const float a = nx[x] - nx[x + shift], b = ny[x] - ny[x + shift], c = nz[x] - nz[x + shift];
      const float d = ar[x] - ar[x + shift], e = ag[x] - ag[x + shift], f = ab[x] - ab[x + shift];
      const float off_plane = z[x] + float(dx) * sx[x] + float(dy) * sy[x] - z[x + shift];
      const float z_scale = depth_tolerance * z[x] + 1e-6f;
      float distance = std::max(color, 0.0f);
      distance = std::max(distance, (a * a + b * b + c * c) * normal_scale);
      distance = std::max(distance, (d * d + e * e + f * f) * albedo_scale);
      distance = std::max(distance, off_plane * off_plane / (z_scale * z_scale));
      weight[x] = falling_exponential(distance);
    }
    float* total = &weights_[std::size_t(y) * tile_size];
    for (int x = 0; x < tile_size; ++x) total[x] += weight[x];
    for (int channel = 0; channel < 3; ++channel) {
      float* sum = &sums_[channel][std::size_t(y) * tile_size];
      const float* light = &light_[channel][start + shift];
      for (int x = 0; x < tile_size; ++x) sum[x] += weight[x] * light[x];
    }
  }

  static constexpr int rows_ = tile_size + 2 * patch_radius;
  static constexpr int border_ = most_radius + patch_radius, stride_ = tile_size + 2 * border_;
  static constexpr float tolerance2_ = color_tolerance * color_tolerance;
  int radius_;
  std::array<Plane, 3> light_, normal_, albedo_, sums_;
  Plane variance_, depth_, slope_x_, slope_y_, weights_;
  Plane patch_ = Plane(std::size_t(rows_) * tile_size);  // sums along rows of patches
};

}  // namespace

Image denoise(const TracedImage& guides, const NoisyLight& light, const DenoiseOptions& options) {
  const int width = guides.albedo.width, height = guides.albedo.height;
  assert(light.width == width && light.height == height && guides.depth.height == height);
  Image result(width, height);
  if (width == 0 || height == 0) return result;
  const Planes planes = split(guides, light);
  const int columns = (width + tile_size - 1) / tile_size, tiles = columns * ((height + tile_size - 1) / tile_size);
  parallel_blocks(tiles, 1, [&](Eigen::Index index, Eigen::Index) {
    const int left = int(index % columns) * tile_size, top = int(index / columns) * tile_size;
    Tile tile(planes, left, top, options.strength * options.strength, options.radius);
    tile.filter();
    for (int y = 0; y < std::min(tile_size, height - top); ++y)
      for (int x = 0; x < std::min(tile_size, width - left); ++x)
        for (int c = 0; c < 3; ++c)
          result.pixel(left + x, top + y)[c] =
              tile.value(c, x, y) * std::max(guides.albedo.pixel(left + x, top + y)[c], least_albedo);
  });
  return result;
}

Image denoise(const TracedImage& traced, const DenoiseOptions& options) {
  return options.strength > 0 ? denoise(traced, noisy_light(traced), options) : traced.color;
}

}  // namespace umax
