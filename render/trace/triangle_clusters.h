// Triangles that lie together, in clusters of at most 16 with at most 16 vertices: what moves is traced as them, so that
// the hierarchy above has a fifteenth of the parts and vector code meets all triangles of one at once.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/trace/cluster_hit.h"
#include "render/trace/traced_object.h"

namespace umax {

struct TriangleCluster {
  ClusterCorners corners;
  std::array<unsigned, cluster_size> triangles;  // ascending; the last one fills up
  std::array<unsigned, cluster_size> vertices;   // of the mesh; the last one fills up
};

using TriangleClusters = std::vector<TriangleCluster>;

/// Every triangle in one cluster. Depends on nothing but the arguments: not on positions, so that a mesh has the same
/// clusters in all frames.
TriangleClusters make_clusters(const std::vector<TracedObject::Corners>& triangles, std::size_t num_vertices);

/// Clusters of the meshes that were asked for last, for frames that follow each other.
class ClusterCache {
 public:
  std::shared_ptr<const TriangleClusters> clusters_of(const TracedObject& object);

 private:
  struct Entry {
    std::vector<TracedObject::Corners> triangles;
    std::size_t num_vertices;
    std::shared_ptr<const TriangleClusters> clusters;
  };
  std::vector<Entry> entries_;  // the one that was asked for last comes first
};

}  // namespace umax
