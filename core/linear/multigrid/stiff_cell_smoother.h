// A smoother for single hexes that are much stiffer than their neighbours: an exact solve on each (additive Schwarz
// with hexes as subdomains; Smith, Bjorstad, Gropp, Domain Decomposition, 1996). Such a hex moves like a rigid body,
// which neither a point smoother (its nodes' own blocks are stiff) nor a coarse grid (it is too small) sees.
//
//   L = damping sum_e P_e A_e^-1 P_e^T,   A_e the 24 x 24 block of A at the hex's nodes
// No hex of the lattice touches more than `most_shared` of those solved for, so that the largest eigenvalue of L A is
// at most damping most_shared < 2: one step with L reduces every error.
#pragma once

#include <array>
#include <vector>

#include "core/linear/bricks/hex_operator.h"

namespace umax {

struct StiffCellSmoother {
  using Vector24f = Eigen::Matrix<float, 24, 1>;
  using Matrix24f = Eigen::Matrix<float, 24, 24>;
  using Rows = Eigen::Matrix<float, 24, 192>;
  std::vector<std::array<int, 8>> nodes;     // slots
  std::vector<Matrix24f> inverses;           // damping A_e^-1; zero at nodes that are not free
  std::vector<std::array<int, 64>> reached;  // slots of the 4 x 4 x 4 nodes around, -1: none; only where hexes are few,
  std::vector<Rows> rows;                    // and A between the hex's nodes and those
};

/// Hexes at least `contrast` times stiffer than the softest of those that touch them. Slots in ascending order decide
/// where too many lie close to each other. most_rows: for so many hexes and no more, A's rows are stored.
StiffCellSmoother make_stiff_cell_smoother(const HexOperator& op, const HexMatrix<float>& matrix,
                                           const Matrix24d& stiffness, double contrast, Eigen::Index most_rows = 0);

/// z += L r.
void add_corrections(const StiffCellSmoother& cells, const AlignedArray<float>& r, AlignedArray<float>& z);

/// With A's rows, the hexes are solved for around a preconditioner B without a sweep over the lattice:
/// `before` is what L r is hex by hex, and rest becomes r - A L r.
std::vector<StiffCellSmoother::Vector24f> correct_before(const StiffCellSmoother& cells, const AlignedArray<float>& r,
                                                         AlignedArray<float>& rest);

/// z = B rest becomes z' = L r + z + L (r - A (L r + z)). Returns r . z' - rest . z.
double correct_after(const StiffCellSmoother& cells, const AlignedArray<float>& r,
                     const std::vector<StiffCellSmoother::Vector24f>& before, AlignedArray<float>& z);

}  // namespace umax
