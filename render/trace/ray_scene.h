// The triangles of a scene in the form that rays are traced against. Embree stays behind this header.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/ray.h"
#include "render/scene/render_scene.h"

namespace umax {

/// What shading needs to know of a point on a surface.
struct SurfacePoint {
  Vector3f position;          // [m] on the triangle
  Vector3f geometric_normal;  // unit, on the side that the ray came from
  Vector3f normal;            // unit, interpolated where the mesh has normals, on the same side
  Vector3f smooth_position;   // [m] on the curved surface that the normals mean, outside the triangle or on it: shadow
                              // rays start there, or coarse meshes get dark steps [Hanika 2021]
  float offset = 0;           // [m] bound on the error of position
  Vector3f base_color;        // of the look, its texture or the mesh's colours
};

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
  /// positions that are not finite.
  explicit RayScene(const RenderScene& scene);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  Hit intersect(const Ray& ray) const;
  /// The same for rays that lie close together, faster.
  void intersect_coherent(const Ray* rays, int count, Hit* hits) const;
  bool occluded(const Ray& ray) const;
  SurfacePoint surface(const Hit& hit, const Vector3f& ray_direction) const;

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
