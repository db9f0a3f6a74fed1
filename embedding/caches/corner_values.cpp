#include "embedding/caches/corner_values.h"

#include <bit>
#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace umax {
namespace {

/// The bits of a pair: equal for equal pairs, 0 and -0 apart.
std::uint64_t key_of(const Eigen::RowVector2f& value) {
  return std::uint64_t(std::bit_cast<std::uint32_t>(value.x())) << 32 | std::bit_cast<std::uint32_t>(value.y());
}

}  // namespace

CornerValues distinct_values(const TextureCoordinates& corners) {
  CornerValues result;
  result.index.reserve(std::size_t(corners.rows()));
  std::unordered_map<std::uint64_t, int> known;
  for (const auto& corner : corners.rowwise()) {
    const auto [entry, is_new] = known.try_emplace(key_of(corner), int(result.values.size()));
    if (is_new) result.values.emplace_back(corner);
    result.index.push_back(entry->second);
  }
  return result;
}

SplitVertices split_vertices(Eigen::Index num_vertices, const Triangles& triangles, const TextureCoordinates& corners) {
  SplitVertices split;
  split.source.resize(std::size_t(num_vertices));
  std::iota(split.source.begin(), split.source.end(), 0);
  split.triangles = triangles;
  if (corners.rows() == 0) return split;

  split.coordinates.assign(std::size_t(num_vertices), Eigen::RowVector2f::Zero());
  std::vector<char> has_value(std::size_t(num_vertices), 0);
  std::vector<int> next_copy(std::size_t(num_vertices), -1);  // of a vertex, own or copy: a copy of the same
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector2f value = corners.row(3 * t + k);
      int vertex = triangles(t, k);
      if (!has_value[std::size_t(vertex)]) {
        has_value[std::size_t(vertex)] = 1;
        split.coordinates[std::size_t(vertex)] = value;
      }
      while (split.coordinates[std::size_t(vertex)] != value && next_copy[std::size_t(vertex)] >= 0)
        vertex = next_copy[std::size_t(vertex)];
      if (split.coordinates[std::size_t(vertex)] != value) {
        const int copy = int(split.source.size());
        next_copy[std::size_t(vertex)] = copy;
        split.source.push_back(triangles(t, k));
        split.coordinates.push_back(value);
        next_copy.push_back(-1);
        has_value.push_back(1);
        vertex = copy;
      }
      split.triangles(t, k) = vertex;
    }
  return split;
}

}  // namespace umax
