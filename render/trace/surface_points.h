// What shading needs to know of the points that rays have met, for many of them at once.
#pragma once

#include <vector>

#include "render/trace/path_rows.h"
#include "render/trace/traced_object.h"

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

struct SurfacePointRows {
  rows::DirectionRows position, geometric_normal, normal, smooth_position;
  rows::DirectionRows departure;  // [m] start of rays that leave the surface on the viewer's side
  rows::Row offset;
  rows::ColorRows base_color;
};

/// Fills the first `count` points. It owns rows to work in: one per thread.
class SurfacePoints {
 public:
  void find(const std::vector<TracedObject>& objects, const rows::RayRows& rays, const rows::HitRows& hits, int count,
            SurfacePointRows& to);

 private:
  void gather(const std::vector<TracedObject>& objects, const rows::RayRows& rays, const rows::HitRows& hits, int count,
              SurfacePointRows& to);
  rows::DirectionRows corner_[3], corner_normal_[3];
  rows::Row twice_area_;
  rows::RowOf<int> has_normals_;
};

}  // namespace umax
