// Surface vertices of a hex in small groups, so that what is true of a group need not be asked of each.
#pragma once

#include <vector>

#include "core/model/model.h"

namespace umax {

struct VertexCluster {
  int first = 0, count = 0;                       // into VertexClusters::points
  Vector3d centre{0, 0, 0}, half_sizes{0, 0, 0};  // [-] local coordinates of its box in the hex
};

/// Constant during a run.
struct VertexClusters {
  std::vector<int> hex_starts;     // #E + 1 into all
  std::vector<VertexCluster> all;  // by hex
  std::vector<int> points;         // surface vertices, by cluster
};

/// hex_starts, hex_points: the surface vertices by hex, as in ContactGeometry.
VertexClusters cluster_vertices(const Model& model, const std::vector<int>& hex_starts,
                                const std::vector<int>& hex_points);

/// Vertices of a cluster are far from each other in memory: the processor may fetch the weights of all while it waits for the
/// first.
inline void fetch_weights(const Model::BodyRange& body, const VertexClusters& clusters, const VertexCluster& cluster) {
  for (int k = cluster.first; k < cluster.first + cluster.count; ++k)
    __builtin_prefetch(surface_weights(body, clusters.points[std::size_t(k)]).data());
}

/// Half of a hex's longest edge along each axis of its local coordinates [m].
Vector3d longest_half_edges(const Matrix8x3d& nodes);

/// A sphere that the cluster's vertices are in, where its hex has these nodes and longest_half_edges().
struct ClusterSphere {
  Vector3d centre{0, 0, 0};  // [m]
  double radius = 0;         // [m]
};
ClusterSphere sphere_around(const VertexCluster& cluster, const Matrix8x3d& nodes, const Vector3d& half_edges);

}  // namespace umax
