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

// Cuts the vertices in halves along the longest side of their box until they are few.
void split(const Model::BodyRange& body, std::vector<int>::iterator begin, std::vector<int>::iterator end, int first,
           std::vector<VertexCluster>& clusters) {
  Eigen::AlignedBox3d box;
  for (auto point = begin; point != end; ++point) box.extend(local_place(body, *point));
  if (end - begin <= most_vertices) {
    clusters.push_back({first, int(end - begin), box.center(), 0.5 * box.sizes()});
    return;
  }
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    return std::pair(local_place(body, a)[axis], a) < std::pair(local_place(body, b)[axis], b);
  });
  split(body, begin, middle, first, clusters);
  split(body, middle, end, first + int(middle - begin), clusters);
}

}  // namespace

VertexClusters cluster_vertices(const Model& model, const std::vector<int>& hex_starts,
                                const std::vector<int>& hex_points) {
  VertexClusters clusters{std::vector<int>(hex_starts.size(), 0), {}, hex_points};
  std::vector<std::vector<VertexCluster>> of_hexes(std::size_t(model.num_hexes()));
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index hex = begin; hex < end; ++hex)
      if (hex_starts[hex] < hex_starts[hex + 1])
        split(model.bodies[std::size_t(model.hex_body[hex])], clusters.points.begin() + hex_starts[hex],
              clusters.points.begin() + hex_starts[hex + 1], hex_starts[hex], of_hexes[std::size_t(hex)]);
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
