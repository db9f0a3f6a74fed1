// The library that finds what rays meet, Embree, which stays behind this header: triangles that stand still as its own,
// those that move in clusters.
#pragma once

#include <memory>

#include "render/scene/rows.h"
#include "render/trace/moving_clusters.h"
#include "render/trace/traced_object.h"

namespace umax {

enum class HierarchyBuild {
  good,  // for pictures of many paths
  fast,  // three times as fast to build, rays take a little longer
};

/// The library at work; hierarchies of a scene share one.
class RayDevice {
 public:
  RayDevice();
  ~RayDevice();
  RayDevice(const RayDevice&) = delete;
  RayDevice& operator=(const RayDevice&) = delete;
  void* get() const { return device_; }

 private:
  void* device_;
};

/// Objects that rays are traced against.
class RayHierarchy {
 public:
  static constexpr int packet_size = 8;  // rays that the library traces together

  RayHierarchy(std::shared_ptr<const RayDevice> device, HierarchyBuild build);
  ~RayHierarchy();
  RayHierarchy(const RayHierarchy&) = delete;
  RayHierarchy& operator=(const RayHierarchy&) = delete;

  /// Of what is added, vertices and triangles are read where they lie as long as rays are traced.
  void add(const TracedObject& object, unsigned id);
  void add(const MovingClusters& clusters, unsigned id);
  /// On all threads; before the first ray.
  void build();
  bool has_motion() const { return has_motion_; }

  Hit intersect(const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  /// Up to packet_size rays of these numbers, which lie close together.
  void intersect(const rows::RayRows& rays, const int* numbers, int count, rows::HitRows& hits) const;
  /// blocked of these numbers: 1 where something lies before the ray's largest distance, else 0.
  void occluded(const rows::RayRows& rays, const int* numbers, int count, rows::RowOf<int>& blocked) const;

 private:
  std::shared_ptr<const RayDevice> device_;
  void* scene_;
  HierarchyBuild build_;
  bool has_motion_ = false;
};

}  // namespace umax
