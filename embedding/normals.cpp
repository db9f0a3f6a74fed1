#include "embedding/normals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "embedding/topology.h"

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
  }

  /// Appends the chains of vertices [first, last) to entries; sizes[v - first] is how many entries each got.
  void build(int first, int last, std::vector<int>& entries, std::vector<int>& sizes) const {
    std::vector<RimEdge> rim;
    for (int v = first; v < last; ++v) {
      const std::size_t before = entries.size();
      collect_rim(v, rim);
      append_chains(rim, entries);
      sizes.push_back(int(entries.size() - before));
    }
  }

 private:
  Vector3d normal(int t) const {
    const Vector3d a = mesh_.positions.row(mesh_.triangles(t, 0)), b = mesh_.positions.row(mesh_.triangles(t, 1)),
                   c = mesh_.positions.row(mesh_.triangles(t, 2));
    return (b - a).cross(c - a);
  }

  void collect_rim(int v, std::vector<RimEdge>& rim) const {
    rim.clear();
    const int group = welded_[v];
    const auto first = corners_.corners.begin() + corners_.offsets[group];
    const auto last = corners_.corners.begin() + corners_.offsets[group + 1];
    const auto is_own = [&](int corner) { return mesh_.triangles(corner / 3, corner % 3) == v; };

    // a vertex that shares its position sees the other triangles only across gentle angles
    Vector3d own = Vector3d::Zero();
    if (shared_[group])
      for (auto it = first; it != last; ++it)
        if (is_own(*it)) own += normal(*it / 3);
    for (auto it = first; it != last; ++it) {
      const int t = *it / 3, corner = *it % 3;
      if (shared_[group] && !is_own(*it)) {
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

}  // namespace

VertexFans make_vertex_fans(const TriangleMesh& mesh, double crease_degrees) {
  const FanBuilder builder(mesh, crease_degrees);

  // blocks of vertices in parallel, joined in order
  constexpr int block_size = 8192;
  const int num_vertices = int(mesh.num_vertices()), num_blocks = (num_vertices + block_size - 1) / block_size;
  std::vector<std::vector<int>> entries(num_blocks), sizes(num_blocks);
  tbb::parallel_for(0, num_blocks, [&](int b) {
    builder.build(b * block_size, std::min(num_vertices, (b + 1) * block_size), entries[b], sizes[b]);
  });
  VertexFans fans;
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
  for (Eigen::Index v = first; v < last; ++v) {
    const double px = x[3 * v], py = x[3 * v + 1], pz = x[3 * v + 2];
    double ax = 0, ay = 0, az = 0, nx = 0, ny = 0, nz = 0;
    const int* end = fans.entries.data() + fans.offsets[v + 1];
    for (const int* entry = fans.entries.data() + fans.offsets[v]; entry != end; ++entry) {
      const bool starts = *entry < 0;
      const double* q = x + 3 * std::ptrdiff_t(starts ? ~*entry : *entry);
      const double bx = q[0] - px, by = q[1] - py, bz = q[2] - pz;
      if (!starts) {
        nx += ay * bz - az * by;
        ny += az * bx - ax * bz;
        nz += ax * by - ay * bx;
      }
      ax = bx, ay = by, az = bz;
    }
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const bool sound = length > 0 && std::isfinite(length);
    const double inverse = sound ? 1 / length : 0;
    double* n = normals.data() + 3 * v;
    n[0] = nx * inverse;
    n[1] = sound ? ny * inverse : 1;
    n[2] = nz * inverse;
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
