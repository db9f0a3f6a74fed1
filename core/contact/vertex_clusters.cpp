#include "core/contact/vertex_clusters.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr std::ptrdiff_t most_vertices = 16;  // of a cluster
constexpr Eigen::Index hexes_per_block = 64;

double sign_of(int corner, int axis) {
  return corner & (4 >> axis) ? 1 : -1;
}

// trilinear weights reproduce what is linear, so they tell where the point is
Vector3d local_place(const Model::BodyRange& body, int point) {
  const auto weights = surface_weights(body, point);
  Vector3d s = Vector3d::Zero();
  for (int n = 0; n < 8; ++n)
    for (int axis = 0; axis < 3; ++axis) s[axis] += weights[n] * sign_of(n, axis);
  return s;
}

struct Placed {
  Vector3d place;  // [-] in the hex
  int point;
};

// Cuts the vertices in halves along the longest side of their box until they are few.
void split(std::vector<Placed>::iterator begin, std::vector<Placed>::iterator end, int first,
           std::vector<VertexCluster>& clusters) {
  Eigen::AlignedBox3d box;
  for (auto placed = begin; placed != end; ++placed) box.extend(placed->place);
  if (end - begin <= most_vertices) {
    clusters.push_back({first, int(end - begin), box.center(), 0.5 * box.sizes()});
    return;
  }
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](const Placed& a, const Placed& b) {
    return std::pair(a.place[axis], a.point) < std::pair(b.place[axis], b.point);
  });
  split(begin, middle, first, clusters);
  split(middle, end, first + int(middle - begin), clusters);
}

// Clusters of the hex's vertices, which are put in the clusters' order.
std::vector<VertexCluster> cluster_hex(const Model::BodyRange& body, int* points, int first, int count) {
  std::vector<Placed> placed;
  placed.reserve(std::size_t(count));
  for (int k = first; k < first + count; ++k) placed.push_back({local_place(body, points[k]), points[k]});
  std::vector<VertexCluster> clusters;
  split(placed.begin(), placed.end(), first, clusters);
  for (int k = 0; k < count; ++k) points[first + k] = placed[std::size_t(k)].point;
  return clusters;
}

}  // namespace

VertexClusters cluster_vertices(const Model& model, const std::vector<int>& hex_starts,
                                const std::vector<int>& hex_points) {
  VertexClusters clusters{std::vector<int>(hex_starts.size(), 0), {}, hex_points};
  std::vector<std::vector<VertexCluster>> of_hexes(std::size_t(model.num_hexes()));
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index hex = begin; hex < end; ++hex)
      if (hex_starts[hex] < hex_starts[hex + 1])
        of_hexes[std::size_t(hex)] = cluster_hex(body_of(model, hex), clusters.points.data(), hex_starts[hex],
                                                 hex_starts[hex + 1] - hex_starts[hex]);
  });
  for (std::size_t hex = 0; hex < of_hexes.size(); ++hex) {
    std::move(of_hexes[hex].begin(), of_hexes[hex].end(), std::back_inserter(clusters.all));
    clusters.hex_starts[hex + 1] = int(clusters.all.size());
  }
  return clusters;
}

Vector3d longest_half_edges(const Matrix8x3d& nodes) {
  Vector3d squares = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis)
    for (int n = 0; n < 8; ++n)
      if (sign_of(n, axis) < 0)
        squares[axis] = std::max(squares[axis], (nodes.row(n | (4 >> axis)) - nodes.row(n)).squaredNorm());
  return 0.5 * squares.cwiseSqrt();
}

ClusterSphere sphere_around(const VertexCluster& cluster, const Matrix8x3d& nodes, const Vector3d& half_edges) {
  return {nodes.transpose() * shape_functions(cluster.centre), cluster.half_sizes.dot(half_edges)};
}

}  // namespace umax
