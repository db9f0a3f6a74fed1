// The surface of a body at rest, exactly: its triangles, to measure how deep a point of the material lies and where its
// nearest way out is.
//
// Sign and normal where the nearest point lies on an edge or a corner: angle-weighted pseudonormals (Baerentzen and
// Aanaes 2005, Signed distance computation using the angle weighted pseudonormal, IEEE TVCG 11).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// Distances at the points of a grid, each found when it is first asked for: what a point is at least away from the
/// surface costs one look-up then. The values do not depend on who asks first.
struct DistanceCache {
  Vector3d origin{0, 0, 0};  // [m]
  double spacing = 0;        // [m]
  Vector3i size{0, 0, 0};
  std::unique_ptr<std::atomic<float>[]> values;  // [m] NaN: not asked for yet
};

/// Made by make_rest_surface(); read-only afterwards.
struct RestSurface {
  /// Of a bounding volume hierarchy with up to four children a node, whose boxes are looked at all at once (Wald, Benthin
  /// and Boulos 2008, Getting rid of packets, IEEE Symposium on Interactive Ray Tracing).
  struct Node {
    std::array<Eigen::Array4d, 3> low, high;  // [m] of the children's boxes, by axis; empty boxes of none
    std::array<int, 4> first{}, count{};      // leaf: in `order`; count 0: the node `first`; -1: no child
  };
  Points vertices;          // #V x 3 [m]
  Triangles triangles;      // #T x 3, counter-clockwise from outside; of vertices at one place, the first
  Points triangle_normals;  // #T x 3 unit; a needle's is that of its neighbours, its own would be rounding
  // pseudonormals, unit, or zero where the triangles' normals cancel
  Points edge_normals;      // 3 #T x 3, row 3 t + k of the edge from corner k to corner k + 1
  Points vertex_normals;    // #V x 3
  Eigen::AlignedBox3d box;  // of all triangles
  std::vector<Node> nodes;  // the root first, parents before their children; none where there are no triangles
  std::vector<int> order;   // triangles, by leaf
  std::vector<std::array<Vector3d, 3>>
      corners;  // [m] of the triangles in `order`: side by side in memory, for searches
  DistanceCache cache;
};

/// Place of corner k of triangle t [m].
inline Vector3d corner_of(const RestSurface& surface, int t, int k) {
  return surface.vertices.row(surface.triangles(t, k)).transpose();
}

/// Triangles without area are left out. Edges that border one triangle or more than two are allowed; the sign near them
/// is that of the triangles there.
RestSurface make_rest_surface(const Points& vertices, const Triangles& triangles);

/// The same triangles with all vertices elsewhere [m]: their normals are new, and the hierarchy's boxes. It has no cache.
RestSurface moved_surface(const RestSurface& surface, const Points& vertices);

struct SurfaceHit {
  int triangle = -1;                    // -1: none
  Vector3d point = Vector3d::Zero();    // [m] nearest of the surface
  Vector3d normal = Vector3d::UnitY();  // unit, out of the surface: the gradient of the distance
  double distance = 0;                  // [m] negative inside
};

/// The nearest point of the surface; triangle -1 where nothing is as near as `reach` [m]. Of equally near triangles the
/// one with the lowest index counts.
SurfaceHit nearest_point(const RestSurface& surface, const Vector3d& point, double reach);

/// Bounds of the signed distance [m] at a point, from one of the grid's near it.
struct DistanceBounds {
  double low = 0, high = 0;
};
DistanceBounds distance_bounds(const RestSurface& surface, const Vector3d& point);

/// nearest_point() among the triangles whose normals have at least this cosine with a direction (unit): the side of a
/// thin wall that a point came through. At the border of these triangles the sign is that of the nearest one's plane.
SurfaceHit nearest_alike(const RestSurface& surface, const Vector3d& point, const Vector3d& direction, double cosine,
                         double reach);

/// The first and the last triangle that the segment crosses from its front to its back; -1: none.
int first_entered(const RestSurface& surface, const Vector3d& from, const Vector3d& to);
int last_entered(const RestSurface& surface, const Vector3d& from, const Vector3d& to);

/// The surface at another size: bodies that differ in their size alone share one, and its cache. What is asked of it, as
/// of a surface, and what it answers is at that size. It must not outlive the surface.
struct ScaledSurface {
  const RestSurface& of;
  double scale = 1;  // [-] of lengths, more than 0
};

inline Vector3d triangle_normal(const ScaledSurface& surface, int t) {
  return surface.of.triangle_normals.row(t).transpose();
}
SurfaceHit nearest_point(const ScaledSurface& surface, const Vector3d& point, double reach);
DistanceBounds distance_bounds(const ScaledSurface& surface, const Vector3d& point);
SurfaceHit nearest_alike(const ScaledSurface& surface, const Vector3d& point, const Vector3d& direction, double cosine,
                         double reach);
int first_entered(const ScaledSurface& surface, const Vector3d& from, const Vector3d& to);
int last_entered(const ScaledSurface& surface, const Vector3d& from, const Vector3d& to);

/// The surface's distances at an affine map of points: many points of one map cost a product and a look-up each.
struct DistanceView {
  const RestSurface* surface = nullptr;
  double scale = 1;                             // as in ScaledSurface
  Matrix3d grid_from_point = Matrix3d::Zero();  // [1/m] into the cache's grid, whose points are 1 apart
  Vector3d grid_origin = Vector3d::Zero();      // [-]
};
/// Of points x whose images, in the frame of the surface, are  linear x + translation.
DistanceView view_distances(const ScaledSurface& surface, const Matrix3d& linear, const Vector3d& translation);

/// distance_bounds().low at a point's image; infinity: the surface has no cache.
double least_distance(const DistanceView& view, const Vector3d& point);

}  // namespace umax
