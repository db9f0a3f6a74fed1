// A moving object's clusters with their vertices at all instants: boxes for the hierarchy, and what a ray meets.
//
// Where triangles are long, thin and aslant, their boxes lie over each other in thousands, and a ray would come through
// all of them. There each cluster is put into the hierarchy in parts, slices with small boxes [Ernst and Greiner 2007,
// Early Split Clipping for Bounding Volume Hierarchies]; in any of them the whole cluster is what a ray meets. Objects
// that stand still are traced as clusters, too, if they are like that.
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

  /// Keeps no reference to the object, which may stand still. clusters: of its triangles.
  MovingClusters(const TracedObject& object, std::shared_ptr<const TriangleClusters> clusters);

  /// Parts, each of which has boxes: as a rule the clusters.
  std::size_t count() const { return parts_.size(); }
  /// Even times from 0 to 1: between the boxes of one and the next lies what the cluster is in meanwhile.
  std::size_t num_steps() const { return num_steps_; }
  const Box& box(std::size_t part, std::size_t step) const { return boxes_[part * num_steps_ + step]; }
  std::size_t cluster_of(std::size_t part) const { return parts_[part].cluster; }
  /// The nearest up to `most`; hit.triangle is one of the mesh.
  ClusterHit hit(std::size_t part, const ShearedRay& ray, float time, float most) const {
    const std::size_t cluster = parts_[part].cluster;
    const InstantTimes::Place place = times_.at(time);
    const ClusterPositions* before = &positions_[cluster * num_instants() + std::size_t(place.segment)];
    const ClusterPositions* after = num_instants() > 1 ? before + 1 : before;
    const TriangleCluster& topology = (*clusters_)[cluster];
    ClusterHit hit = hit_cluster(ray, most, *before, *after, place.share, topology.corners);
    if (hit.found()) hit.triangle = int(topology.triangles[hit.triangle]);
    return hit;
  }

 private:
  // what of a cluster lies between two places along an axis at the first instant, or all of it
  struct Part {
    unsigned cluster;
    int axis = whole;
    float from = 0, to = 0;  // [m]
    static constexpr int whole = -1;
  };
  // a point on an edge of a cluster's triangles
  struct EdgePoint {
    int a, b;     // among the cluster's vertices
    float share;  // of b
  };
  std::size_t num_instants() const { return std::size_t(times_.num_instants); }
  void find_parts();
  void find_boxes(std::size_t part, const std::vector<float>& bends);
  std::vector<EdgePoint> corners_of(const Part& part) const;
  Box box_at(const Part& part, const std::vector<EdgePoint>& corners, float time, float margin) const;
  ClusterPositions positions_at(std::size_t cluster, float time) const;

  std::shared_ptr<const TriangleClusters> clusters_;
  InstantTimes times_;
  std::size_t num_steps_;
  std::unique_ptr<ClusterPositions[]> positions_;  // of the first cluster at all instants, of the second, ...
  std::vector<Part> parts_;
  std::vector<Box> boxes_;  // of the first part at all steps, of the second, ...
};

/// Does a ray through the object come through the boxes of very many triangles?
bool is_sliced(const TracedObject& object);

}  // namespace umax
