// The built-in shapes, boxes, spheres, cylinders and rings, as closed surfaces fine enough to bend with their cage.
#pragma once

#include "core/base/triangle_mesh.h"

namespace umax {

/// Box of the given size [m] centred at the origin, hard edges, about 48 squares along its longest edge.
TriangleMesh make_box(const Vector3d& size);

/// Sphere centred at the origin: an icosahedron refined `subdivisions` times (20 * 4^n triangles), every vertex at
/// exactly the radius [m] but for rounding, normals exact.
TriangleMesh make_sphere(double radius, int subdivisions = 5);

/// Cylinder along x centred at the origin, flat caps with a hard rim, about 21,000 triangles for a 1 m x 12 cm beam.
TriangleMesh make_cylinder(double radius, double length);

/// Ring (torus) around z centred at the origin: the circle in the middle of its thickness has this radius [m]. About 24,600
/// triangles. Throws Error (bad_data) where it leaves no hole.
TriangleMesh make_ring(double radius, double thickness);

/// Bowl that stands with its bottom on the origin: a cap of a spherical shell, 65 degrees from the axis to a rounded rim
/// of this radius [m], measured in the middle of its thickness [m].
TriangleMesh make_bowl(double radius, double thickness);

/// Horizontal square at y = 0, facing up, size x size [m].
TriangleMesh make_plane(double size);

}  // namespace umax
