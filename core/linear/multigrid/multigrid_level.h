// One grid of a multigrid: its matrix, its vectors, and how both go from it to the next coarser grid.
#pragma once

#include <vector>

#include "core/linear/bricks/hex_operator.h"
#include "core/linear/bricks/multigrid_kernel.h"

namespace umax {

struct MultigridLevel {
  HexShape shape;
  double largest_eigenvalue = 0;  // of D^-1 A: a bound, from one cell
  HexOperator op;                 // with the lattice
  HexMatrix<float> matrix;
  AlignedArray<float> inverse;  // D^-1
  AlignedArray<float> b;        // right-hand side; none on the first level
  AlignedArray<float> x[2];     // iterates
  std::vector<ChebyshevStep> steps;
  Vector3i factor{2, 2, 2};             // to the next level
  std::vector<BrickParents> parents;    // of the next level's bricks
  std::vector<BrickChildren> children;  // of this level's bricks

  const BrickLattice& lattice() const { return op.lattice; }
};

/// Of the instruction set that the level's operator runs on.
inline const MultigridKernels& kernels_of(const MultigridLevel& level) {
  return multigrid_kernels(level.op.instruction_set);
}

/// Calls call(first, last) for blocks of bricks that cover the lattice, in parallel. bricks_per_block: as for_each_column().
template <class Call>
void for_each_block(const BrickLattice& lattice, const Call& call, int bricks_per_block = 8) {
  for_each_column(
      lattice,
      [&](int first, int last) {
        call(first, last);
        return 0.0;
      },
      bricks_per_block);
}

/// Finds the parents and children between a level and the lattice of the next one.
void connect(MultigridLevel& fine, const BrickLattice& coarse);

/// Memory for the level's matrix and vectors.
void allocate(MultigridLevel& level, bool is_first);

/// What kernels need to know of two levels.
Transfer transfer_between(const MultigridLevel& fine, const MultigridLevel& coarse);

/// to = P^T from, for a vector.
void restrict_vector(const MultigridLevel& fine, const AlignedArray<float>& from, const MultigridLevel& coarse,
                     AlignedArray<float>& to);

/// The coarse level's matrix from the fine one's; overwrites fine.x[0] at nodes.
void coarsen_matrix(MultigridLevel& fine, MultigridLevel& coarse);

/// level.inverse = D^-1, the inverses of the matrix's 3 x 3 diagonal blocks.
void invert_blocks(MultigridLevel& level);

}  // namespace umax
