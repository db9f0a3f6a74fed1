// Which deformed hexes of a body come close to others that they are not tied to, by their convex hulls alone.
#pragma once

#include <array>
#include <vector>

#include "core/model/model.h"
#include "tests/support/surface_tree.h"

namespace umax::test {

/// A deformed hex between the planes that its faces have on average.
struct HexHull {
  Matrix8x3d nodes;                 // [m]
  Box box;                          // around the nodes
  std::array<Vector3d, 3> normals;  // unit; zero of a hex without extent
  Vector3d low, high;               // [m] the nodes' extent along the normals
};

/// Of the body's hexes at a state's node positions.
std::vector<HexHull> hex_hulls(const Model& model, int body, const Points& node_positions);

/// May x be within `margin` [m] of the hull? Never wrong with a no: then a plane lies between the two.
bool may_hold(const HexHull& hull, const Vector3d& x, double margin);

/// Per hex of the body, those that share no node with it and whose hulls may come within `margin` [m] of its own. Never
/// one too few.
std::vector<std::vector<int>> close_hexes(const Model& model, int body, const std::vector<HexHull>& hulls,
                                          double margin);

/// The given hexes of the model and all that share a node with one of them, ascending.
std::vector<int> hexes_around(const Model& model, const std::vector<int>& hexes);

}  // namespace umax::test
