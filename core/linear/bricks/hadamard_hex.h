// The stiffness of a box-shaped hex in the Walsh-Hadamard basis of its nodes (8 vectors of signs: translation, strains
// and hourglass modes, as Flanagan and Belytschko 1981 use them), in which few entries are not zero.
#pragma once

#include "core/element/hexahedron.h"
#include "core/linear/bricks/hex_kernel.h"

namespace umax {

/// Of a box (a cell of a regular lattice); an assert fails for any other shape. Per unit of Young's modulus, in [m].
HexConstants<double> make_hex_constants(const HexShape& box);

HexConstants<float> to_float(const HexConstants<double>& constants);

/// Largest eigenvalue of D^-1 K, D the 3 x 3 blocks on K's diagonal: bounds that of the whole matrix, whatever the
/// rotations and multipliers of the hexes, their masses and the fixed nodes.
double largest_jacobi_eigenvalue(const HexShape& box);

/// Shape of a cell of a regular lattice.
HexShape make_box_shape(const Vector3d& cell_size, double poisson);

}  // namespace umax
