// The objects of a scene, and what rays meet of them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/trace/ray_hierarchy.h"
#include "render/trace/surface_points.h"

namespace umax {

/// One ray as it was traced, for measuring what tracing alone costs.
struct RecordedRay {
  Ray ray;
  bool any_hit = false;  // a shadow ray
};
using RayRecording = std::vector<std::vector<RecordedRay>>;  // per tile, in traced order

struct ReplayResult {
  std::uint64_t num_rays = 0, checksum = 0;  // the checksum is over hits: object, triangle, blocked or not
  double seconds = 0;
};

class RayScene {
 public:
  /// Copies what it needs and builds the hierarchy on all threads. Throws Error 65 for indices out of range and
  /// positions that are not finite. cache: for scenes that follow each other; results do not depend on it.
  explicit RayScene(const RenderScene& scene, HierarchyBuild build = HierarchyBuild::good,
                    ClusterCache* cache = nullptr);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  Hit intersect(const Ray& ray) const;
  /// The same of one object alone, whose look has subsurface.
  Hit intersect_object(unsigned object, const Ray& ray) const;
  bool occluded(const Ray& ray) const;
  /// The first `count` rays at once. coherent: they lie close together, which is faster where it is true.
  void intersect(const rows::RayRows& rays, int count, bool coherent, rows::HitRows& hits) const;
  /// blocked[i]: 1 where something lies before the ray's largest distance, else 0.
  void occluded(const rows::RayRows& rays, int count, bool coherent, rows::RowOf<int>& blocked) const;
  const std::vector<TracedObject>& objects() const;
  SurfacePoint surface(const Hit& hit, const Vector3f& ray_direction, float time = 0) const;

  /// Traces a recording again with bare library calls, tiles in parallel.
  ReplayResult replay(const RayRecording& recording) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Start of a ray that leaves the surface in a direction: just off the surface, on that side.
inline Vector3f leave_surface(const SurfacePoint& point, const Vector3f& direction) {
  const bool outside = direction.dot(point.geometric_normal) >= 0;
  return outside ? Vector3f(point.smooth_position + point.offset * point.geometric_normal)
                 : Vector3f(point.position - point.offset * point.geometric_normal);
}

}  // namespace umax
