// Each pixel's light as the frames around it show it. A neighbour counts as far as it shows the same points: what was
// hidden, off the picture or of another object or colour is left out. It counts as far as these are lit alike, too: the
// mean difference of a small square, and the mean of its squares, must be what the noise of both explains.
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/srgb.h"
#include "render/trace/clip_frame.h"

namespace umax {
namespace {

constexpr int tile_size = 64;     // [px]
constexpr int square_radius = 3;  // [px] of what light is compared over
constexpr int stride = tile_size + 2 * square_radius, cells = stride * stride;
constexpr float albedo_tolerance2 = 0.01f;    // sum of squares over the channels
constexpr float still_tolerance2 = 0.004f;    // of albedo and of normals, where nothing moves and so both are the same
constexpr float distance_tolerance = 0.003f;  // of the distance itself
constexpr float least_weight = 0.2f;          // of the four pixels around a place
constexpr float unseen_change = 0.005f;       // of the light: passes for the same

using Cells = std::array<float, cells>;

// what a tile and its border see in one frame
struct Seen {
  std::array<Cells, 3> first, second;  // light of the two halves
  Cells variance;                      // of the mean of both, as the paths tell it
  Cells counts;                        // 1: there, 0: not
  Cells light_first, light_second;     // luminances
};

// a sky that is seen by itself is not noisy: what other frames had before it would only spoil it
bool is_bare_sky(const SeenPoint& point) {
  return point.object == Hit::nothing && !(point.variance > 0);
}

float squared_distance(const float* a, const float* b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// sums over squares, in place: first along rows, then along columns
void sum_squares(Cells& values) {
  constexpr int r = square_radius;
  Cells rows;
  for (int y = 0; y < stride; ++y)
    for (int x = r; x < stride - r; ++x) {
      const float* v = &values[y * stride + x];
      rows[y * stride + x] = v[-3] + v[-2] + v[-1] + v[0] + v[1] + v[2] + v[3];
    }
  for (int y = r; y < stride - r; ++y)
    for (int x = r; x < stride - r; ++x) {
      const float* v = &rows[y * stride + x];
      values[y * stride + x] =
          v[-3 * stride] + v[-2 * stride] + v[-stride] + v[0] + v[stride] + v[2 * stride] + v[3 * stride];
    }
}

class Gatherer {
 public:
  Gatherer(const ClipFrame& centre, int left, int top)
      : centre_(centre), left_(left - square_radius), top_(top - square_radius) {
    see_itself();
    for (int h = 0; h < 2; ++h) weights_[h].fill(1);
    sums_ = {seen_.first, seen_.second};
    squares_ = seen_.variance;
    own_ = seen_;
  }

  /// Whether there is light to gather.
  bool is_noisy() const {
    for (int y = square_radius; y < stride - square_radius; ++y)
      for (int x = square_radius; x < stride - square_radius; ++x) {
        const int row = std::min(top_ + y, centre_.height - 1), column = std::min(left_ + x, centre_.width - 1);
        if (!is_bare_sky(centre_.point(column, row))) return true;
      }
    return false;
  }

  void gather(const ClipFrame& frame, const Reprojection& reprojection) {
    if (!look_at(frame, reprojection)) return;
    compare();
    for (int i = 0; i < cells; ++i) {
      const float a = accepted_[0][i], b = accepted_[1][i], mean = 0.5f * (a + b);
      for (int c = 0; c < 3; ++c) {
        sums_[0][c][i] += a * seen_.first[c][i];
        sums_[1][c][i] += b * seen_.second[c][i];
      }
      weights_[0][i] += a;
      weights_[1][i] += b;
      squares_[i] += mean * mean * seen_.variance[i];
    }
  }

  void store(NoisyLight& to) const {
    for (int y = square_radius; y < stride - square_radius && top_ + y < to.height; ++y)
      for (int x = square_radius; x < stride - square_radius && left_ + x < to.width; ++x)
        store_pixel(y * stride + x, std::size_t(top_ + y) * to.width + left_ + x, to);
  }

 private:
  void see_itself() {
    for (int y = 0; y < stride; ++y)
      for (int x = 0; x < stride; ++x) {
        const int row = std::clamp(top_ + y, 0, centre_.height - 1),
                  column = std::clamp(left_ + x, 0, centre_.width - 1), i = y * stride + x;
        clear(i);
        add(centre_.point(column, row), 1, i);
        finish(i, 1);
      }
  }

  void clear(int i) {
    for (int c = 0; c < 3; ++c) seen_.first[c][i] = seen_.second[c][i] = 0;
    seen_.variance[i] = seen_.counts[i] = seen_.light_first[i] = seen_.light_second[i] = 0;
  }
  void add(const SeenPoint& point, float weight, int i) {
    for (int c = 0; c < 3; ++c) {
      seen_.first[c][i] += weight * point.first[c];
      seen_.second[c][i] += weight * point.second[c];
    }
    seen_.variance[i] += weight * weight * point.variance;
  }
  void finish(int i, float weight) {
    const float scale = 1 / weight;
    for (int c = 0; c < 3; ++c) seen_.first[c][i] *= scale, seen_.second[c][i] *= scale;
    seen_.variance[i] *= scale * scale;
    seen_.counts[i] = 1;
    seen_.light_first[i] = luminance(seen_.first[0][i], seen_.first[1][i], seen_.first[2][i]);
    seen_.light_second[i] = luminance(seen_.second[0][i], seen_.second[1][i], seen_.second[2][i]);
  }

  // false: nothing of the tile is there
  bool look_at(const ClipFrame& frame, const Reprojection& reprojection) {
    bool any = false;
    for (int y = 0; y < stride; ++y)
      for (int x = 0; x < stride; ++x) {
        const int i = y * stride + x, column = left_ + x, row = top_ + y;
        clear(i);
        if (column < 0 || row < 0 || column >= centre_.width || row >= centre_.height) continue;
        const Reprojection::Place place = reprojection.place(column, row);
        const SeenPoint& here = centre_.point(column, row);
        if (!place.has_place || is_bare_sky(here)) continue;
        const float weight = add_around(frame, place, here, reprojection.stands_still(here.object), i);
        if (weight < least_weight) {
          clear(i);
        } else {
          finish(i, weight);
          any = true;
        }
      }
    return any;
  }

  // the four pixels around a place, of those that show the point; returns their share
  float add_around(const ClipFrame& frame, const Reprojection::Place& place, const SeenPoint& here, bool still, int i) {
    const float x = place.x - 0.5f, y = place.y - 0.5f;
    if (!(x > -1 && y > -1 && x < float(frame.width) && y < float(frame.height))) return 0;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - float(x0), fy = y - float(y0);
    float weight = 0;
    for (int k = 0; k < 4; ++k) {
      const int tap_x = x0 + (k & 1), tap_y = y0 + (k >> 1);
      const float share = (k & 1 ? fx : 1 - fx) * (k >> 1 ? fy : 1 - fy);
      if (!(share > 1e-3f) || tap_x < 0 || tap_y < 0 || tap_x >= frame.width || tap_y >= frame.height) continue;
      const SeenPoint& there = frame.point(tap_x, tap_y);
      if (!is_same_point(here, there, place.distance, still)) continue;
      add(there, share, i);
      weight += share;
    }
    return weight;
  }

  static bool is_same_point(const SeenPoint& here, const SeenPoint& there, float distance, bool still) {
    return there.object == here.object &&
           std::abs(there.distance - distance) <= distance_tolerance * distance + there.slope &&
           squared_distance(there.albedo, here.albedo) <= (still ? still_tolerance2 : albedo_tolerance2) &&
           (!still || squared_distance(there.normal, here.normal) <= still_tolerance2);
  }

  // how much of the frame's halves counts: each as the other tells
  void compare() {
    Cells count = seen_.counts, noise, differences, squares;
    for (int i = 0; i < cells; ++i) {
      const float a = own_.light_first[i] - own_.light_second[i], b = seen_.light_first[i] - seen_.light_second[i];
      noise[i] = 0.5f * seen_.counts[i] * (a * a + b * b);
    }
    sum_squares(count);
    sum_squares(noise);
    for (int h = 0; h < 2; ++h) {
      const Cells &here = h == 0 ? own_.light_first : own_.light_second,
                  &there = h == 0 ? seen_.light_first : seen_.light_second;
      for (int i = 0; i < cells; ++i) {
        const float difference = there[i] - here[i];
        differences[i] = seen_.counts[i] * difference;
        squares[i] = seen_.counts[i] * difference * difference;
      }
      sum_squares(differences);
      sum_squares(squares);
      accept(count, noise, differences, squares, here, accepted_[1 - h]);
    }
  }

  void accept(const Cells& count, const Cells& noise, const Cells& differences, const Cells& squares,
              const Cells& light, Cells& accepted) const {
    for (int i = 0; i < cells; ++i) {
      const float n = std::max(count[i], 1.0f), unseen = unseen_change * light[i];
      const float variance = noise[i] / n + 1e-12f, mean = differences[i] / n;
      const float shift = mean * mean / (variance / n + unseen * unseen);  // 1 on the average where nothing changes
      const float excess =
          (squares[i] / n - variance) / (variance * std::sqrt(2 / n) + unseen * unseen);  // 0, with deviation 1
      const float doubt =
          std::max(std::max(shift * (1.0f / shift_tolerance), excess * (1.0f / excess_tolerance)) - 1, 0.0f);
      accepted[i] = seen_.counts[i] / (1 + doubt * doubt * doubt * doubt);
    }
  }

  void store_pixel(int i, std::size_t to, NoisyLight& light) const {
    std::array<float, 3> mean, half;
    for (int c = 0; c < 3; ++c) {
      half[c] = sums_[0][c][i] / weights_[0][i];
      mean[c] = 0.5f * (half[c] + sums_[1][c][i] / weights_[1][i]);
      light.light[c][to] = mean[c];
      light.half[c][to] = half[c];
    }
    const float weight = 0.5f * (weights_[0][i] + weights_[1][i]);
    light.of_paths[to] = squares_[i] / (weight * weight);
    if (centre_.has_color_noise) {
      for (int c = 0; c < 3; ++c) light.of_halves[to] += (mean[c] - half[c]) * (mean[c] - half[c]) / 3;
      return;
    }
    const float apart = luminance(mean[0], mean[1], mean[2]) - luminance(half[0], half[1], half[2]);
    light.of_halves[to] = apart * apart;
  }

  static constexpr float shift_tolerance = 3, excess_tolerance = 3;
  const ClipFrame& centre_;
  int left_, top_;
  Seen own_, seen_;
  std::array<std::array<Cells, 3>, 2> sums_;
  std::array<Cells, 2> weights_, accepted_;
  Cells squares_;
};

}  // namespace

NoisyLight gather_light(const std::vector<const ClipFrame*>& window, std::size_t centre) {
  const ClipFrame& frame = *window[centre];
  std::vector<Reprojection> reprojections;
  for (const ClipFrame* other : window) reprojections.emplace_back(frame, *other);
  NoisyLight light = empty_light(frame.width, frame.height);
  const int columns = (frame.width + tile_size - 1) / tile_size,
            tiles = columns * ((frame.height + tile_size - 1) / tile_size);
  parallel_blocks(tiles, 1, [&](Eigen::Index tile, Eigen::Index) {
    const auto gatherer =
        std::make_unique<Gatherer>(frame, int(tile % columns) * tile_size, int(tile / columns) * tile_size);
    for (std::size_t k = 0; k < window.size(); ++k)
      if (k != centre && gatherer->is_noisy()) gatherer->gather(*window[k], reprojections[k]);
    gatherer->store(light);
  });
  return light;
}

}  // namespace umax
