#include "render/trace/surface_points.h"

#include <cmath>

namespace umax {
namespace {

using rows::HitRows;
using rows::RayRows;
using Vertex = TracedObject::Vertex;

inline Direction select(bool first, const Direction& a, const Direction& b) {
  return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
}
inline Direction cross(const Direction& a, const Direction& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float largest(const Direction& a) {
  const float x = std::abs(a.x), y = std::abs(a.y), z = std::abs(a.z), xy = x > y ? x : y;
  return xy > z ? xy : z;
}

// how far the tangent plane at a vertex lies outside the triangle's point
inline Direction lift_to_tangent(const Direction& point, const Direction& vertex, const Direction& normal) {
  const float height = dot(point - vertex, normal);
  return select(height < 0, -height * normal, {0, 0, 0});
}

// shading normal on the viewer's side of both surfaces, so that no point of a silhouette is black
inline Direction bend_towards(const Direction& normal, const Direction& to_viewer) {
  constexpr float least_cosine = 0.02f;
  const float cosine = dot(normal, to_viewer);
  const Direction bent = normal + (least_cosine - cosine) * to_viewer;
  return select(cosine >= least_cosine, normal, bent / std::sqrt(dot(bent, bent)));
}

// of a triangle so small that its area is lost in single precision
Direction normal_of_sliver(const Direction& a, const Direction& b, const Direction& c) {
  const Direction n = cross(b - a, c - a);
  const Vector3f unit = Vector3f(n.x, n.y, n.z).stableNormalized();
  return direction_of(unit);
}

// the numbers of a vertex, between two instants where it moves
Vertex vertex_at(const TracedObject& object, const TracedObject::Instant& instant, unsigned index) {
  const Vertex& before = object.vertices[instant.before + index];
  if (!object.is_moving()) return before;
  const Vertex& after = object.vertices[instant.after + index];
  const float rest = 1 - instant.share;
  Vertex vertex;
  for (int c = 0; c < 3; ++c) {
    vertex.position[c] = rest * before.position[c] + instant.share * after.position[c];
    vertex.normal[c] = rest * before.normal[c] + instant.share * after.normal[c];
  }
  return vertex;
}

}  // namespace

// Vertices lie anywhere in memory: all are asked for before the first is waited for.
void SurfacePoints::gather(const std::vector<TracedObject>& objects, const RayRows& rays, const HitRows& hits,
                           int count, SurfacePointRows& to) {
  for (int i = 0; i < count; ++i) __builtin_prefetch(&objects[hits.object[i]].triangles[hits.triangle[i]]);
  for (int i = 0; i < count; ++i) {
    const TracedObject& object = objects[hits.object[i]];
    const TracedObject::Instant instant = object.at(rays.time[i]);
    for (const unsigned index : object.triangles[hits.triangle[i]].index) {
      __builtin_prefetch(&object.vertices[instant.before + index]);
      if (object.is_moving()) __builtin_prefetch(&object.vertices[instant.after + index]);
    }
  }
  for (int i = 0; i < count; ++i) {
    const TracedObject& object = objects[hits.object[i]];
    const TracedObject::Instant instant = object.at(rays.time[i]);
    for (int c = 0; c < 3; ++c) {
      const Vertex vertex = vertex_at(object, instant, object.triangles[hits.triangle[i]].index[c]);
      corner_[c].set(i, Direction{vertex.position[0], vertex.position[1], vertex.position[2]});
      corner_normal_[c].set(i, Direction{vertex.normal[0], vertex.normal[1], vertex.normal[2]});
    }
    has_normals_[i] = object.has_normals ? 1 : 0;
    const float u = hits.u[i], v = hits.v[i];
    const Vector3f color = object.color_at(hits.triangle[i], 1 - u - v, u, v);
    to.base_color.set(i, {color.x(), color.y(), color.z()});
  }
}

void SurfacePoints::find(const std::vector<TracedObject>& objects, const RayRows& rays, const HitRows& hits, int count,
                         SurfacePointRows& to) {
  gather(objects, rays, hits, count, to);
  for (int i = 0; i < count; ++i) {
    const Direction a = corner_[0].at(i), n = cross(corner_[1].at(i) - a, corner_[2].at(i) - a);
    twice_area_[i] = std::sqrt(dot(n, n));
    to.geometric_normal.set(i, n / twice_area_[i]);
  }
  for (int i = 0; i < count; ++i)
    if (!(twice_area_[i] > 1e-18f))
      to.geometric_normal.set(i, normal_of_sliver(corner_[0].at(i), corner_[1].at(i), corner_[2].at(i)));
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const float u = hits.u[i], v = hits.v[i], w = 1 - u - v;
    const Direction a = corner_[0].at(i), b = corner_[1].at(i), c = corner_[2].at(i);
    const Direction position = w * a + u * b + v * c, towards = rays.direction.at(i);
    const Direction face = to.geometric_normal.at(i);
    const bool flipped = dot(face, towards) > 0;
    const Direction geometric = select(flipped, -face, face);
    const float side = flipped ? -1.0f : 1.0f;
    const float offset = 4e-6f * (largest(a) + largest(b) + largest(c));
    // the curved surface that the normals mean
    const Direction na = side * corner_normal_[0].at(i), nb = side * corner_normal_[1].at(i),
                    nc = side * corner_normal_[2].at(i);
    const Direction sum = w * na + u * nb + v * nc;
    const float length2 = dot(sum, sum);
    const bool is_smooth = (has_normals_[i] != 0) & (length2 > 1e-12f);
    const Direction smooth = bend_towards(sum / std::sqrt(length2), -towards);
    const Direction lift = w * lift_to_tangent(position, a, na) + u * lift_to_tangent(position, b, nb) +
                           v * lift_to_tangent(position, c, nc);
    const Direction smooth_position = select(is_smooth, position + lift, position);
    to.position.set(i, position);
    to.geometric_normal.set(i, geometric);
    to.normal.set(i, select(is_smooth, smooth, geometric));
    to.smooth_position.set(i, smooth_position);
    to.offset[i] = offset;
    to.departure.set(i, smooth_position + offset * geometric);
  }
}

}  // namespace umax
