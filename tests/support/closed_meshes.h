// Closed surfaces to test with, in triangles as small as a test wants them.
#pragma once

#include "core/base/triangle_mesh.h"

namespace umax::test {

/// The faces of the box [low, high], each in a grid of so many parts along the axes; faces share no vertices.
TriangleMesh box_mesh(const Vector3d& low, const Vector3d& high, const Vector3i& parts);

/// Such a cube's faces, blown up to a ball.
TriangleMesh ball_mesh(const Vector3d& centre, double radius, int parts);

/// Both meshes as one, a's vertices and triangles first.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);

}  // namespace umax::test
