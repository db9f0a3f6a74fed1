// PLY: a surface in one frame, binary, with normals, velocities, texture coordinates and colours.
#pragma once

#include <string>

#include "embedding/caches/moving_surface.h"

namespace umax {

/// The file's bytes. Vertices keep their order and number: a vertex whose corners have several texture coordinates has
/// those of its first corner as `s` and `t`, and all stand with the faces (`texcoord`).
std::string ply_bytes(const MovingSurface& surface, const SurfaceFrame& frame);

}  // namespace umax
