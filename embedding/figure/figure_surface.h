// A closed surface from a signed distance function: narrow-band grid, dual contouring, relaxed vertices.
#pragma once

#include <functional>

#include "core/base/triangle_mesh.h"
#include "embedding/surface/level_set.h"

namespace umax {

struct SurfaceOptions {
  Vector3d min{-1, 0, -1}, max{1, 2, 1};        // [m] box that holds the surface
  double cell_size = 6.5e-3;                    // [m]
  int relaxations = 4;                          // rounds that even out the triangles
  std::function<bool(const Vector3d& p)> fine;  // where triangles get half the size; empty: nowhere
};

/// Triangles of the zero level set, counter-clockwise from outside, with unit normals. The same bytes for any number of
/// threads. Features thinner than two cells may be lost.
TriangleMesh level_set_surface(const DistanceFunction& distance, const SurfaceOptions& options);

}  // namespace umax
