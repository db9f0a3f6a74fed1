// Exact solves on single hexes that are much stiffer than their neighbours. Such a hex moves like a rigid body, which
// neither a point smoother (its nodes' own blocks are stiff) nor a coarse grid (it is too small) sees.
//
//   L = damping sum_e P_e A_e^-1 P_e^T,   A_e the 24 x 24 block of A at the hex's nodes
// No hex of the lattice touches more than `most_shared` of those solved for, so that the largest eigenvalue of L A is
// at most damping most_shared < 2: one step with L reduces every error.
#pragma once

#include <array>
#include <vector>

#include "core/hex_operator.h"

namespace umax {

struct StiffCells {
  using Matrix24f = Eigen::Matrix<float, 24, 24>;
  std::vector<std::array<int, 8>> nodes;  // slots
  std::vector<Matrix24f> inverses;        // damping A_e^-1; zero at nodes that are not free
};

/// Hexes at least `contrast` times stiffer than the softest of those that touch them. Slots in ascending order decide
/// where too many lie close to each other.
StiffCells find_stiff_cells(const HexOperator& op, const HexMatrix<float>& matrix, const Matrix24d& stiffness,
                            double contrast);

/// z += L r.
void add_corrections(const StiffCells& cells, const AlignedArray<float>& r, AlignedArray<float>& z);

}  // namespace umax
