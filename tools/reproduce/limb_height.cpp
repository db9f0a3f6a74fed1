#include "tools/reproduce/limb_height.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace umax {
namespace {

constexpr double slab = 0.15;  // [-] of the limb's height

Vector3d mean_of(const std::vector<int>& vertices, const Points& positions) {
  Vector3d sum = Vector3d::Zero();
  for (const int vertex : vertices) sum += positions.row(vertex);
  return sum / double(vertices.size());
}

struct Range {
  double low = 0, high = 0;  // [m]
};

Range heights_of(const std::vector<int>& vertices, const Points& positions) {
  Range range{positions(vertices.front(), 1), positions(vertices.front(), 1)};
  for (const int vertex : vertices) {
    range.low = std::min(range.low, positions(vertex, 1));
    range.high = std::max(range.high, positions(vertex, 1));
  }
  return range;
}

}  // namespace

Limb select_limb(const Points& rest, const LimbBox& box) {
  // the vertices in the box
  Limb limb;
  if (rest.rows() > 0) {
    const Vector3d origin = rest.colwise().minCoeff(), size = rest.colwise().maxCoeff() - origin.transpose();
    const Vector3d low = origin + box.low.cwiseProduct(size), high = origin + box.high.cwiseProduct(size);
    for (int i = 0; i < int(rest.rows()); ++i) {
      const Vector3d p = rest.row(i);
      if ((p.array() >= low.array()).all() && (p.array() <= high.array()).all()) limb.vertices.push_back(i);
    }
  }
  if (limb.vertices.empty())
    throw Error(Fault::bad_data, {.where = "limb",
                                  .what = "no vertex of the surface lies in its box",
                                  .value = fmt::format("({}, {}, {}) to ({}, {}, {}) of the bounding box", box.low[0],
                                                       box.low[1], box.low[2], box.high[0], box.high[1], box.high[2]),
                                  .remedy = "choose a box that holds the limb"});

  // its two ends
  const auto [bottom, top] = heights_of(limb.vertices, rest);
  for (const int vertex : limb.vertices) {
    if (rest(vertex, 1) >= top - slab * (top - bottom)) limb.top.push_back(vertex);
    if (rest(vertex, 1) <= bottom + slab * (top - bottom)) limb.bottom.push_back(vertex);
  }
  limb.rest_height = limb_height(limb, rest);
  limb.rest_length = limb_length(limb, rest);
  return limb;
}

double limb_height(const Limb& limb, const Points& positions) {
  const Range heights = heights_of(limb.vertices, positions);
  return heights.high - heights.low;
}

double limb_length(const Limb& limb, const Points& positions) {
  return (mean_of(limb.top, positions) - mean_of(limb.bottom, positions)).norm();
}

}  // namespace umax
