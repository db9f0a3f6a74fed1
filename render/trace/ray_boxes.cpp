#include "render/trace/ray_boxes.h"

#include <algorithm>
#include <limits>

namespace umax {
namespace {

constexpr std::size_t most_boxes = 8;

// rounding of the distances below, with room to spare: a box that is touched counts as met
constexpr float before = 1 - 1e-6f, beyond = 1 + 1e-6f;

struct Slab {
  float near, far;
};
inline Slab slab(float low, float high, float origin, float direction) {
  const float inverse = 1 / (std::abs(direction) < 1e-18f ? 1e-18f : direction);
  const float a = (low - origin) * inverse, b = (high - origin) * inverse;
  return {a < b ? a : b, a < b ? b : a};
}
inline float larger(float a, float b) {
  return a > b ? a : b;
}
inline float smaller(float a, float b) {
  return a < b ? a : b;
}

}  // namespace

RayBoxes::RayBoxes(const std::vector<TracedObject>& objects) {
  for (const TracedObject& object : objects) {
    if (object.triangles.empty()) continue;
    constexpr float far = std::numeric_limits<float>::max();
    Box box{.low = {far, far, far}, .high = {-far, -far, -far}};
    for (const TracedObject::Vertex& vertex : object.vertices) {
      for (int c = 0; c < 3; ++c) {
        box.low[c] = std::min(box.low[c], vertex.position[c]);
        box.high[c] = std::max(box.high[c], vertex.position[c]);
      }
    }
    if (boxes_.size() < most_boxes) {
      boxes_.push_back(box);
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      boxes_.back().low[c] = std::min(boxes_.back().low[c], box.low[c]);
      boxes_.back().high[c] = std::max(boxes_.back().high[c], box.high[c]);
    }
  }
}

void RayBoxes::find(const rows::RayRows& rays, int count, rows::RowOf<int>& may_hit) const {
  for (int i = 0; i < count; ++i) may_hit[i] = 0;
  for (const Box& box : boxes_) {
    for (int i = 0; i < count; ++i) {
      const Slab x = slab(box.low[0], box.high[0], rays.origin.x[i], rays.direction.x[i]);
      const Slab y = slab(box.low[1], box.high[1], rays.origin.y[i], rays.direction.y[i]);
      const Slab z = slab(box.low[2], box.high[2], rays.origin.z[i], rays.direction.z[i]);
      const float near = larger(larger(x.near, y.near), larger(z.near, 0));
      const float far = smaller(smaller(x.far, y.far), smaller(z.far, rays.max_distance[i]));
      may_hit[i] |= near * before <= far * beyond ? 1 : 0;
    }
  }
}

}  // namespace umax
