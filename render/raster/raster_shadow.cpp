#include "render/raster/raster_shadow.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace umax::raster {
namespace {

struct Projected {
  float x, y, z;  // [px], [px], depth; z < 0: behind the light
};

void project(const Frame& frame, const Matrix4f& shadow_from_world, int size, std::vector<Projected>& out) {
  const Matrix4f& m = shadow_from_world;
  out.resize(frame.vertices.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vector3f& p = frame.vertices[i].position;
    const auto row = [&](int r) { return m(r, 0) * p[0] + m(r, 1) * p[1] + m(r, 2) * p[2] + m(r, 3); };
    const float w = row(3), scale = w > 1e-6f ? 1 / w : 0;
    // what lies before the near plane still throws its shadow
    out[i] = {row(0) * scale * float(size), row(1) * scale * float(size),
              w > 1e-6f ? std::max(row(2) * scale, 0.0f) : -1};
  }
}

/// Keeps the nearest depth of a triangle at the pixel centres that it covers, edges included.
void draw_triangle(Projected a, Projected b, Projected c, float* map, int size) {
  if (a.z < 0 || b.z < 0 || c.z < 0) return;
  const auto clamped = [&](float value) { return int(std::clamp(value, -1.0f, float(size))); };
  const int x0 = std::max(clamped(std::ceil(std::min({a.x, b.x, c.x}) - 0.5f)), 0);
  const int x1 = std::min(clamped(std::floor(std::max({a.x, b.x, c.x}) - 0.5f)), size - 1);
  if (x0 > x1) return;  // most triangles of a fine mesh lie between pixel centres
  const int y0 = std::max(clamped(std::ceil(std::min({a.y, b.y, c.y}) - 0.5f)), 0);
  const int y1 = std::min(clamped(std::floor(std::max({a.y, b.y, c.y}) - 0.5f)), size - 1);
  if (y0 > y1) return;
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (area == 0 || !std::isfinite(area)) return;
  if (area < 0) std::swap(b, c);
  const float scale = 1 / std::abs(area);
  for (int y = y0; y <= y1; ++y) {
    const float py = float(y) + 0.5f;
    for (int x = x0; x <= x1; ++x) {
      const float px = float(x) + 0.5f;
      const float wa = (c.x - b.x) * (py - b.y) - (c.y - b.y) * (px - b.x);
      const float wb = (a.x - c.x) * (py - c.y) - (a.y - c.y) * (px - c.x);
      const float wc = (b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x);
      if (wa < 0 || wb < 0 || wc < 0) continue;
      float& depth = map[std::size_t(y) * size + x];
      depth = std::min(depth, scale * (wa * a.z + wb * b.z + wc * c.z));
    }
  }
}

}  // namespace

std::vector<float> draw_shadow_maps(const Frame& frame, const std::vector<LightSample>& samples, int size) {
  const std::size_t map_size = std::size_t(size) * size;
  std::vector<float> maps(map_size * std::max<std::size_t>(samples.size(), 1), 1.0f);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), 1), [&](const auto& range) {
    std::vector<Projected> points;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      project(frame, samples[i].shadow_from_world, size, points);
      for (const Batch& batch : frame.batches) {
        if (batch.is_ground) continue;
        for (int k = batch.first_index; k < batch.first_index + batch.num_indices; k += 3)
          draw_triangle(points[frame.indices[k]], points[frame.indices[k + 1]], points[frame.indices[k + 2]],
                        &maps[i * map_size], size);
      }
    }
  });
  return maps;
}

}  // namespace umax::raster
