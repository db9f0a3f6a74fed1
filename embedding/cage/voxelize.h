// The cage around a mesh: a regular lattice that holds every vertex and fills the inside.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/lattice.h"

namespace umax {

struct CageOptions {
  /// Wanted number of cells (cubes; the nearest number that a cell size can give), grid of the bounding box (its cells
  /// fit the box exactly), or the cells' edge [m] (cubes).
  std::variant<int, Vector3i, double> size = 365;
  bool whole_box = false;         // every cell of the bounding box, not only those that touch the solid
  long long max_cells = 5000000;  // [-] more are refused before memory is taken
};

struct CageReport {
  std::string method;              // "level set" or "winding numbers": how inside was told from outside
  std::vector<std::string> notes;  // what was wrong with the surface and what was done; empty for a sound closed mesh
  double mesh_volume = 0;          // [m^3] enclosed by the surface, holes capped, overlapping parts counted twice
  double level_set_volume = 0;     // [m^3] enclosed by OpenVDB's level set
  double filled_volume = 0;        // [m^3] sum of filled fraction times cell volume
  int num_islands = 0;             // parts of the cage that share no node
  int num_loose_parts = 0;         // parts that share no face (hinged parts count apart)
};

/// Counts the islands and loose parts of a cage, regular or not, and notes where there are several.
void report_connections(const Lattice& lattice, CageReport& report);

/// Throws Error (bad_data) for an empty mesh, sizes that are not positive, and more than max_cells cells.
Lattice voxelize(const TriangleMesh& mesh, const CageOptions& options, CageReport* report = nullptr);

}  // namespace umax
