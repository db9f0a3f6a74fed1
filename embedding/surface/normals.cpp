#include "embedding/surface/normals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>
#include <utility>

#include "embedding/surface/topology.h"

namespace umax {
namespace {

struct RimEdge {
  int from = 0, to = 0;
};

// #welded vertex -> its corners (3 t + corner), in order of triangles
struct Corners {
  std::vector<int> offsets, corners;
};

Corners collect_corners(const Triangles& triangles, const std::vector<int>& welded) {
  Corners result;
  result.offsets.assign(welded.size() + 1, 0);
  for (int corner : triangles.reshaped()) ++result.offsets[welded[corner] + 1];
  for (std::size_t v = 0; v < welded.size(); ++v) result.offsets[v + 1] += result.offsets[v];
  result.corners.resize(3 * triangles.rows());
  std::vector<int> next(result.offsets.begin(), result.offsets.end() - 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int corner = 0; corner < 3; ++corner)
      result.corners[next[welded[triangles(t, corner)]]++] = int(3 * t + corner);
  return result;
}

// joins rim edges head to tail; chains that are open at their start come first
void append_chains(std::vector<RimEdge>& rim, std::vector<int>& entries) {
  constexpr std::size_t max_linked = 64;  // quadratic search: a fan of thousands is left as single edges
  std::vector<char> used(rim.size(), 0);
  const auto follow = [&](std::size_t start) {
    entries.push_back(~rim[start].from);
    for (std::size_t e = start; e < rim.size();) {
      used[e] = 1;
      entries.push_back(rim[e].to);
      const int head = rim[e].to;
      e = rim.size();
      if (rim.size() > max_linked) continue;
      for (std::size_t next = 0; next < rim.size() && e == rim.size(); ++next)
        if (!used[next] && rim[next].from == head) e = next;
    }
  };
  const auto has_predecessor = [&](std::size_t e) {
    return std::any_of(rim.begin(), rim.end(), [&](const RimEdge& other) { return other.to == rim[e].from; });
  };
  if (rim.size() <= max_linked)
    for (std::size_t e = 0; e < rim.size(); ++e)
      if (!used[e] && !has_predecessor(e)) follow(e);
  for (std::size_t e = 0; e < rim.size(); ++e)
    if (!used[e]) follow(e);
}

class FanBuilder {
 public:
  FanBuilder(const TriangleMesh& mesh, double crease_degrees)
      : mesh_(mesh),
        welded_(weld(mesh.positions)),
        corners_(collect_corners(mesh.triangles, welded_)),
        min_cosine_(std::cos(crease_degrees * std::numbers::pi / 180)) {
    shared_.assign(welded_.size(), 0);
    for (std::size_t v = 0; v < welded_.size(); ++v)
      if (welded_[v] != int(v)) shared_[welded_[v]] = 1;
    // where vertices keep to their own, each finds these at once
    for (std::size_t v = 0; v < welded_.size(); ++v)
      if (shared_[v] && num_corners(int(v)) > most_seen)
        std::stable_sort(corners_.corners.begin() + corners_.offsets[v],
                         corners_.corners.begin() + corners_.offsets[v + 1],
                         [&](int a, int b) { return vertex_at(a) < vertex_at(b); });
  }

  /// Appends the chains of the vertices to entries, and to sizes how many entries each got.
  void build(std::span<const int> vertices, std::vector<int>& entries, std::vector<int>& sizes) const {
    std::vector<RimEdge> rim;
    for (int v : vertices) {
      const std::size_t before = entries.size();
      collect_rim(v, rim);
      append_chains(rim, entries);
      sizes.push_back(int(entries.size() - before));
    }
  }

 private:
  static constexpr int most_seen = 2048;

  int num_corners(int group) const { return corners_.offsets[group + 1] - corners_.offsets[group]; }
  int vertex_at(int corner) const { return mesh_.triangles(corner / 3, corner % 3); }

  Vector3d normal(int t) const {
    const Vector3d a = mesh_.positions.row(mesh_.triangles(t, 0)), b = mesh_.positions.row(mesh_.triangles(t, 1)),
                   c = mesh_.positions.row(mesh_.triangles(t, 2));
    return (b - a).cross(c - a);
  }

  void collect_rim(int v, std::vector<RimEdge>& rim) const {
    rim.clear();
    const int group = welded_[v];
    auto first = corners_.corners.begin() + corners_.offsets[group];
    auto last = corners_.corners.begin() + corners_.offsets[group + 1];
    const auto is_own = [&](int corner) { return vertex_at(corner) == v; };

    // A vertex that shares its position sees the other triangles only across gentle angles; not where each of thousands
    // would see thousands.
    const bool sees_others = shared_[group] && num_corners(group) <= most_seen;
    if (shared_[group] && !sees_others) {
      first = std::partition_point(first, last, [&](int corner) { return vertex_at(corner) < v; });
      last = std::partition_point(first, last, [&](int corner) { return vertex_at(corner) == v; });
    }
    Vector3d own = Vector3d::Zero();
    if (sees_others)
      for (auto it = first; it != last; ++it)
        if (is_own(*it)) own += normal(*it / 3);
    for (auto it = first; it != last; ++it) {
      const int t = *it / 3, corner = *it % 3;
      if (sees_others && !is_own(*it)) {
        const Vector3d other = normal(t);
        if (!(other.dot(own) > min_cosine_ * other.norm() * own.norm())) continue;
      }
      const int from = welded_[mesh_.triangles(t, (corner + 1) % 3)],
                to = welded_[mesh_.triangles(t, (corner + 2) % 3)];
      if (from != to && from != group && to != group) rim.push_back({from, to});
    }
  }

  const TriangleMesh& mesh_;
  std::vector<int> welded_;
  Corners corners_;
  std::vector<char> shared_;  // of welded vertices: more than one vertex lies here
  double min_cosine_;
};

// spreads the lowest 10 bits to every third bit
std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

// vertices along a Morton curve through the bounding box
std::vector<int> spatial_order(const Points& positions) {
  if (positions.rows() == 0) return {};
  const Eigen::RowVector3d low = positions.colwise().minCoeff();
  const double extent = (positions.colwise().maxCoeff() - low).maxCoeff();
  const double scale = extent > 0 ? 1023 / extent : 0;
  std::vector<std::pair<std::uint32_t, int>> keyed(std::size_t(positions.rows()));
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const Eigen::RowVector3d s = (positions.row(v) - low) * scale;
    keyed[std::size_t(v)] = {spread_bits(std::uint32_t(s[0])) << 2 | spread_bits(std::uint32_t(s[1])) << 1 |
                                 spread_bits(std::uint32_t(s[2])),
                             int(v)};
  }
  tbb::parallel_sort(keyed.begin(), keyed.end());
  std::vector<int> order;
  order.reserve(keyed.size());
  for (const auto& [key, v] : keyed) order.push_back(v);
  return order;
}

// x, y, z and a fourth number that means nothing
using Row = double __attribute__((vector_size(32)));

Row load_row(const double* positions, int v, int last) {
  const double* p = positions + 3 * std::ptrdiff_t(v);
  Row row;
  if (v < last)
    std::memcpy(&row, p, sizeof row);  // reads into the next row
  else
    row = Row{p[0], p[1], p[2], 0};
  return row;
}

Row turned(Row a) {  // (y, z, x)
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}

}  // namespace

VertexFans make_vertex_fans(const TriangleMesh& mesh, double crease_degrees) {
  const FanBuilder builder(mesh, crease_degrees);
  VertexFans fans;
  fans.order = spatial_order(mesh.positions);

  // blocks of vertices in parallel, joined in order
  constexpr int block_size = 8192;
  const int num_vertices = int(mesh.num_vertices()), num_blocks = (num_vertices + block_size - 1) / block_size;
  std::vector<std::vector<int>> entries(num_blocks), sizes(num_blocks);
  tbb::parallel_for(0, num_blocks, [&](int b) {
    const int first = b * block_size, last = std::min(num_vertices, first + block_size);
    builder.build(std::span(fans.order).subspan(std::size_t(first), std::size_t(last - first)), entries[b], sizes[b]);
  });
  fans.offsets.reserve(std::size_t(num_vertices) + 1);
  fans.offsets.push_back(0);
  for (int b = 0; b < num_blocks; ++b) {
    for (int size : sizes[b]) fans.offsets.push_back(fans.offsets.back() + size);
    fans.entries.insert(fans.entries.end(), entries[b].begin(), entries[b].end());
  }
  return fans;
}

void compute_normals(const VertexFans& fans, const Points& positions, Eigen::Index first, Eigen::Index last,
                     Points& normals) {
  const double* x = positions.data();
  const int last_vertex = int(positions.rows()) - 1;
  for (Eigen::Index i = first; i < last; ++i) {
    const int v = fans.order[i];
    const Row centre = load_row(x, v, last_vertex);
    const int* end = fans.entries.data() + fans.offsets[i + 1];

    // sum of cross products of the spokes, as (z, x, y)
    Row spoke{}, turned_spoke{}, sum{};
    for (const int* entry = fans.entries.data() + fans.offsets[i]; entry != end; ++entry) {
      const bool starts = *entry < 0;
      const Row next = load_row(x, starts ? ~*entry : *entry, last_vertex) - centre;
      const Row turned_next = turned(next);
      if (!starts) sum += spoke * turned_next - turned_spoke * next;
      spoke = next;
      turned_spoke = turned_next;
    }
    const double nx = sum[1], ny = sum[2], nz = sum[0];
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const bool sound = length > 0 && std::isfinite(length);
    const double inverse = sound ? 1 / length : 0;
    double* n = normals.data() + 3 * std::ptrdiff_t(v);
    n[0] = sound ? nx * inverse : 0;
    n[1] = sound ? ny * inverse : 1;
    n[2] = sound ? nz * inverse : 0;
  }
}

void compute_normals(TriangleMesh& mesh, double crease_degrees) {
  const VertexFans fans = make_vertex_fans(mesh, crease_degrees);
  mesh.normals.resize(mesh.num_vertices(), 3);
  tbb::parallel_for(tbb::blocked_range<Eigen::Index>(0, mesh.num_vertices(), 4096), [&](const auto& range) {
    compute_normals(fans, mesh.positions, range.begin(), range.end(), mesh.normals);
  });
}

}  // namespace umax
