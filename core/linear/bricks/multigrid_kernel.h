// The inner loops of multigrid beside the operator's sweeps (core/linear/bricks/hex_kernel.h): smoothing, going from
// grid to grid, finding rotations; compiled for each instruction set like those. All but the last run over the bricks
// [first, last), whole columns; arrays are in bricks.
#pragma once

#include "core/linear/bricks/hex_kernel.h"

namespace umax {

/// The inverse of A's 3 x 3 diagonal blocks; 0 at nodes that are not free.
struct BlockInversion {
  const Brick* bricks = nullptr;
  const HexConstants<float>* constants = nullptr;
  const float* frames = nullptr;
  const float* diagonal = nullptr;
  float* inverse = nullptr;
};

/// x = gain D^-1 b at nodes; elsewhere x is left as it is.
struct BlockJacobi {
  const std::uint16_t* node_masks = nullptr;  // of BrickLattice
  const float *inverse = nullptr, *b = nullptr;
  float gain = 0;
  float* x = nullptr;
};

/// Which bricks of the finer lattice a coarse one lies on, along each axis from one before it: 0 where there is none.
struct BrickParents {
  std::int32_t fine[27] = {};  // [(di + 1) 9 + (dj + 1) 3 + dk + 1]
};
/// Which coarse bricks a fine one lies in, and the next along each axis.
struct BrickChildren {
  std::int32_t coarse[8] = {};  // [4 di + 2 dj + dk]
  std::int32_t half[3] = {};    // 0 or 1: which half of the coarse brick it covers along each axis
};

/// Between a lattice and the one with `factor` times larger cells.
struct Transfer {
  const Brick* coarse_bricks = nullptr;
  const Brick* fine_bricks = nullptr;
  const BrickParents* parents = nullptr;    // per coarse brick
  const BrickChildren* children = nullptr;  // per fine brick
  int factor[3] = {2, 2, 2};
};

/// Coarse cells: stiffness s = mean of s, rotation = polar factor of the sum of s R. Over coarse bricks.
struct FrameCoarsening {
  Transfer transfer;
  const float* fine = nullptr;
  float* coarse = nullptr;
  std::uint16_t* unresolved = nullptr;  // 64 masks per brick: cells left as sqrt(s) times a matrix that is no rotation
};

/// Frames sqrt(s) R of cells, R the polar factor of the deformation gradient at the centre.
struct RotationSearch {
  const Brick* bricks = nullptr;
  const double* positions = nullptr;  // 3 per node
  const float* stiffness = nullptr;   // s per cell, 0 where there is none
  double quarter_over_size[3] = {};   // 1 / (4 cell_size)
  float* frames = nullptr;
  std::uint16_t* unresolved = nullptr;  // as in FrameCoarsening
};

/// Slices of 16 unknowns each, in vectors with a lane more on both sides, which has the value of the slices below and
/// above: a matrix with ones on its diagonal adds to a slice products of 16 entries with 16 consecutive lanes.
inline constexpr int slice_stride = brick_lanes + 2;
struct EllSlices {
  const std::int32_t *below = nullptr, *above = nullptr;  // slices, -1: none
  const std::int32_t* starts = nullptr;                   // of a slice's entries, and the end
  const std::int32_t* places = nullptr;                   // of an entry: where the lanes begin that it multiplies
  const std::int16_t* entries = nullptr;                  // 16 each
  float unit = 0;                                         // that they are multiples of
};
/// A step of Chebyshev's iteration: rest -= S move, next = momentum move + gain rest, x += next; move and next with the
/// lanes beside.
struct SliceSweep {
  EllSlices slices;
  const float* move = nullptr;
  float *next = nullptr, *rest = nullptr, *x = nullptr;
  float momentum = 0, gain = 0;
};

struct MultigridKernels {
  void (*invert_blocks)(const BlockInversion&, int first, int last) = nullptr;
  void (*coarsen_frames)(const FrameCoarsening&, int first, int last) = nullptr;
  void (*find_rotations)(const RotationSearch&, int first, int last) = nullptr;
  /// coarse = P^T fine for vectors and for numbers per node, over coarse bricks.
  void (*restrict_vectors)(const Transfer&, const float* fine, float* coarse, int first, int last) = nullptr;
  void (*restrict_numbers)(const Transfer&, const float* fine, float* coarse, int first, int last) = nullptr;
  /// fine += P coarse at free nodes, over fine bricks.
  void (*prolong)(const Transfer&, const float* coarse, const float* diagonal, float* fine, int first,
                  int last) = nullptr;
  void (*block_jacobi)(const BlockJacobi&, int first, int last) = nullptr;
  /// p = z + beta p.
  void (*turn)(const float* z, float beta, float* p, int first, int last) = nullptr;
  /// Over slices.
  void (*sweep_slices)(const SliceSweep&, int first, int last) = nullptr;
};

const MultigridKernels& multigrid_kernels(InstructionSet set);

}  // namespace umax
