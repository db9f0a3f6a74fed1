// A moving object's clusters with their vertices at all instants: boxes for the hierarchy, and what a ray meets.
#pragma once

#include <memory>
#include <vector>

#include "render/trace/cluster_hit.h"
#include "render/trace/triangle_clusters.h"

namespace umax {

class MovingClusters {
 public:
  struct Box {
    float low[3], high[3];  // [m]
  };

  /// Keeps no reference to the object. clusters: of its triangles.
  MovingClusters(const TracedObject& object, std::shared_ptr<const TriangleClusters> clusters);

  std::size_t count() const { return clusters_->size(); }
  /// Even times from 0 to 1: between the boxes of one and the next lies what the cluster is in meanwhile.
  std::size_t num_steps() const { return num_steps_; }
  const Box& box(std::size_t cluster, std::size_t step) const { return boxes_[cluster * num_steps_ + step]; }
  /// The nearest up to `most`; hit.triangle is one of the mesh.
  ClusterHit hit(std::size_t cluster, const ShearedRay& ray, float time, float most) const {
    const InstantTimes::Place place = times_.at(time);
    const ClusterPositions* before = &positions_[cluster * num_instants() + std::size_t(place.segment)];
    const TriangleCluster& topology = (*clusters_)[cluster];
    ClusterHit hit = hit_cluster(ray, most, before[0], before[1], place.share, topology.corners);
    if (hit.found()) hit.triangle = int(topology.triangles[hit.triangle]);
    return hit;
  }

 private:
  std::size_t num_instants() const { return std::size_t(times_.num_instants); }
  void find_boxes(std::size_t cluster, const std::vector<float>& bends);
  ClusterPositions positions_at(std::size_t cluster, float time) const;

  std::shared_ptr<const TriangleClusters> clusters_;
  InstantTimes times_;
  std::size_t num_steps_;
  std::unique_ptr<ClusterPositions[]> positions_;  // of the first cluster at all instants, of the second, ...
  std::vector<Box> boxes_;                         // likewise at all steps
};

}  // namespace umax
