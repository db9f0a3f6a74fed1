// What of a body is on and in a mesh of bones, and how it goes along with them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/model/pins.h"
#include "tools/setup/animated_mesh.h"
#include "tools/setup/body_shape.h"

namespace umax {

/// A point between the surfaces of bones: it rides on a triangle and a vertex across the bone, so that it turns and
/// stretches as the bone does.
struct InnerPoint {
  std::array<int, 4> corners{};  // vertices of the bones
  Eigen::Vector4d shares;        // [-] of these, with the sum 1
};

/// What a pin holds of a body by bones.
struct HeldByBones {
  FileVertices vertices;          // of the bones
  std::vector<InnerPoint> inner;  // each is a vertex more, behind those of the bones
};

/// Gives the pin its points (on the bones' triangles, as dense as cells need, and between them where the mesh is closed),
/// which lie in the units and axes of the body's mesh. What reaches out of the cage holds nothing, and that is said.
/// Throws Error (bad_data, not_found): no mesh, or all of it is outside.
HeldByBones hold_bones(const MeshSource& inside, const PlacedMesh& shape, const Lattice& lattice, Pin& pin,
                       std::vector<std::string>& warnings);

/// The motion with a vertex more for each point.
MeshMotion with_inner_points(MeshMotion motion, const std::vector<InnerPoint>& inner);

/// [m] edge of a hex, about.
double cell_of(const Lattice& lattice);

}  // namespace umax
