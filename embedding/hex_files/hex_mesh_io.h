// Meshes of hexahedra from files: Gmsh .msh (1 to 4.1), VTK legacy .vtk and VTK XML .vtu.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace umax {

struct HexMesh {
  Points nodes;                    // #N x 3 in file units and axes: those that hexes use, in the file's order
  Hexes hexes;                     // #E x 8 in the file's order; local order: core/element/hexahedron.h
  VectorXd young_factor;           // #E [-] cell data "young_factor" of .vtk and .vtu; empty: none
  VectorXd limit_factor;           // #E [-] cell data "limit_factor", likewise
  std::vector<std::string> notes;  // what a user may want to know; empty when all is plain
};

/// Whether the file's ending says that it holds hexes: msh, vtk or vtu.
bool is_hex_mesh_file(const std::filesystem::path& path);

/// Reads the 8-node hexes of a file; points, lines and faces in it are left out and noted. Throws Error: not_found
/// (missing, a folder, not readable), bad_data for damaged files, other solid cells, hexes that are inverted or tangled
/// (named with their determinants), nodes at the same place, faces with more than two hexes or with two on one side,
/// coordinates that are not finite or beyond 1e9, factors that are not positive. Nothing is repaired.
HexMesh load_hex_mesh(const std::filesystem::path& path);

}  // namespace umax
