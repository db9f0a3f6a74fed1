// The cage: hexahedra that share nodes. Regular (equal boxes of one grid, as voxelize() makes them) or irregular.
#pragma once

#include "core/base/types.h"

namespace umax {

struct Lattice {
  Points rest_positions;        // #N x 3 [m]; regular: sorted by grid coordinates, x slowest, z fastest
  Hexes hexes;                  // #E x 8 indices into rest_positions, local order: core/element/hexahedron.h
  Cells cells;                  // #E x 3 grid coordinates of each hex, sorted likewise; empty: an irregular mesh
  Vector3d origin{0, 0, 0};     // [m] corner of cell (0, 0, 0)
  Vector3d cell_size{0, 0, 0};  // [m] edge lengths; 0 for an irregular mesh
  VectorXd filled_fraction;     // #E in [0, 1], share of each hex inside the surface

  Eigen::Index num_nodes() const { return rest_positions.rows(); }
  Eigen::Index num_hexes() const { return hexes.rows(); }
  bool is_regular() const { return cells.rows() > 0; }
};

/// Lattice of the given grid cells (any order, no duplicates). filled_fraction is set to 1.
Lattice make_lattice(const Cells& cells, const Vector3d& origin, const Vector3d& cell_size);

/// Full grid of num_cells cells with its lowest corner at origin.
Lattice make_box_lattice(const Vector3i& num_cells, const Vector3d& origin, const Vector3d& cell_size);

/// Irregular lattice of any hexes (local order: core/element/hexahedron.h). filled_fraction is set to 1.
Lattice make_irregular_lattice(const Points& nodes, const Hexes& hexes);

/// The 8 rest positions of a hex.
Matrix8x3d rest_nodes(const Lattice& lattice, Eigen::Index hex);

/// Throws Error (bad_data) unless indices are in range, hexes are not inverted, and sizes agree.
void validate(const Lattice& lattice);

}  // namespace umax
