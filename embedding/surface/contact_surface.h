// The part of a mesh that others can touch: the border between its inside and the outside.
//
// A triangle borders the outside where one of its sides is inside and the other is not (winding.h: inside is where the
// winding number is not 0). The winding numbers on both sides are exact at points of the triangle: every triangle is
// sampled along the axis that it faces most, against those that lie above and below the same point. That costs about a
// microsecond per triangle, so that clean meshes need no test of their own beforehand.
#pragma once

#include "core/base/triangle_mesh.h"

namespace umax {

/// The triangles that border the outside, directed so that their normals point outwards; only positions and triangles
/// are set, the mesh's own positions come first. Parts that are buried in other parts are left out. A triangle that is
/// buried in part stays whole if it is small (1/256 of the mesh's box; more where very many triangles are larger), else it
/// is cut and the buried pieces are left out. Small holes are capped; a part with larger ones (caps of more than 2 % of its area) has no inside and is left
/// out. No triangles: the mesh has no inside.
TriangleMesh contact_surface(const TriangleMesh& mesh);

}  // namespace umax
