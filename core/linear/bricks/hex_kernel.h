// The inner loops of the matrix-free operator, compiled once for each instruction set and chosen at run time.
//
//   y = A x,   A = diag(w) + sum_e Q_e K Q_e^T,   Q_e = sqrt(s_e) R_e in each of the hex's nodes
//
// K in the Walsh-Hadamard basis of a box, u^_m = sum_n (+-1) u_n: 7 modes of 3 components (the constant one has no
// energy) that couple in 45 places only. The transform is done axis by axis and shared by neighbouring cells.
// A task (columns of bricks side by side) computes the cells below its own nodes again instead of exchanging sums:
// every node is written once, by one task, in one order.
#pragma once

#include "core/base/instruction_set.h"
#include "core/linear/bricks/brick.h"

namespace umax {

/// Stiffness of a box in the Walsh-Hadamard basis, divided by Young's modulus; see make_hex_constants(). Symmetric
/// matrices as upper triangles, row by row; modes are named by the axes in which their signs alternate.
template <class T>
struct HexConstants {
  T normal[6] = {};     // (x_x, y_y, z_z): mode, component
  T shear[3][3] = {};   // (x_y, y_x), (x_z, z_x), (y_z, z_y)
  T bend[3][3] = {};    // (xy_y, xz_z), (xy_x, yz_z), (xz_x, yz_y)
  T twist[6] = {};      // (yz_x, xz_y, xy_z)
  T trilinear[3] = {};  // xyz_x, xyz_y, xyz_z
  T corner[6] = {};     // 3 x 3 block of the node with all signs positive, in the nodes' own basis
};

/// What is done with A x at each node. w > 0 marks a free node: others give 0.
enum class Epilogue {
  apply,      // out = A x; returns x . A x
  residual,   // out = b - A x; returns its squared norm
  chebyshev,  // out = keep x + momentum out + gain D^-1 (b - A x); returns b . out
};
inline constexpr int num_epilogues = 3;

/// Arithmetic in T, the matrix stored as S: float here, and double in the tests, which then see more than rounding.
template <class T, class S>
struct Sweep {
  const Brick* bricks = nullptr;
  const std::uint16_t* cell_masks = nullptr;  // of BrickLattice
  const std::uint16_t* node_masks = nullptr;
  const HexConstants<T>* constants = nullptr;
  bool is_cube = false;         // trilinear's three are equal: rotations do not matter to that mode
  const S* frames = nullptr;    // 9 per cell
  const S* diagonal = nullptr;  // w per node
  const T* x = nullptr;         // zero at nodes that are not free
  const T* b = nullptr;
  const float* inverse = nullptr;  // D^-1, 6 per node
  void* out = nullptr;             // T; float where the epilogue is a residual. Not x
  T keep = 0, momentum = 0, gain = 0;
};

/// Does the runs [first, last), a whole task, and returns the epilogue's sum.
template <class T, class S>
using SweepFunction = double (*)(const Sweep<T, S>&, const BrickRun* first, const BrickRun* last);

struct HexKernels {
  SweepFunction<float, float> sweeps[num_epilogues] = {};
};

const HexKernels& hex_kernels(InstructionSet set);

}  // namespace umax
