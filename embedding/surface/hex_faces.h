// The faces of hexahedra: which two hexes share one, and which make the surface.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// Corners of a hex's six faces (local node order: core/element/hexahedron.h), counter-clockwise seen from outside.
inline constexpr std::array<std::array<int, 4>, 6> hex_face_corners{
    {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};

struct HexFace {
  std::array<int, 4> corners{};  // nodes, counter-clockwise seen from outside the hex, the lowest first
  int hex = 0;

  std::array<int, 4> sorted_corners() const;
};

/// The six faces of every hex, sorted by their sorted corners and then by hex: faces of one place lie side by side.
std::vector<HexFace> hex_faces(const Hexes& hexes);

/// Calls visit(first, last) for every run of faces with the same four nodes.
template <class Visit>
void for_each_face(const std::vector<HexFace>& faces, Visit visit) {
  for (std::size_t first = 0; first < faces.size();) {
    std::size_t last = first;
    while (last < faces.size() && faces[last].sorted_corners() == faces[first].sorted_corners()) ++last;
    visit(faces.begin() + std::ptrdiff_t(first), faces.begin() + std::ptrdiff_t(last));
    first = last;
  }
}

/// The faces that belong to one hex only.
std::vector<HexFace> boundary_faces(const Hexes& hexes);

/// Their edges as pairs of nodes, each once, sorted.
std::vector<std::pair<int, int>> outer_edges(const Hexes& hexes);

struct HexSurface {
  TriangleMesh mesh;       // the boundary faces, cut in two from their lowest node; vertices in the order of the nodes
  std::vector<int> nodes;  // #V node of every vertex, ascending
};
HexSurface surface_of(const Points& nodes, const Hexes& hexes);

}  // namespace umax
