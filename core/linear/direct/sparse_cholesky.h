// The direct linear solver: a sparse Cholesky factorisation whose symbolic analysis (CHOLMOD; Chen, Davis, Hager,
// Rajamanickam 2008) is kept from step to step. Its numbers come from core/linear/direct/multifrontal.h.
#pragma once

#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <vector>

#include "core/linear/direct/half_columns.h"
#include "core/linear/direct/system_matrix.h"

namespace umax {

/// All nodes in a fill-reducing order in which subtrees of the elimination tree stay together; those in `last`
/// (ascending) come after everything that they depend on: all that is eliminated after one of them is in `last` too.
/// hexes: #E x 8.
std::vector<int> elimination_order(const Hexes& hexes, Eigen::Index num_nodes, const std::vector<int>& last);

/// Owns a factor. Deterministic: the BLAS is told to use one thread a call, orderings are seeded.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Numeric factorisation; analyses the pattern on the first call, which all later matrices must share. False if the
  /// matrix is not positive definite.
  bool factorize(const SystemMatrix& matrix);

  /// Overwrites each column b (3 #N) with A^-1 b. Columns are solved together (level-3 BLAS).
  void solve(Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const;

  /// The two halves of that for one column: y = L^-1 b (3 #N), in elimination order as columns() says, and L^-T y.
  VectorXd solve_forward(const VectorXd& b) const;
  VectorXd solve_backward(const VectorXd& y) const;

  /// The factor L by its groups of columns, for half_solve() of sparse right-hand sides: rows stand in elimination order,
  /// 3 SystemMatrix::ranks[node] + axis. Valid until the next factorisation.
  SupernodalView columns() const;

 private:
  void analyse(const SystemMatrix& matrix);
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Calls visit(i) for 0 <= i < count, each of which may make factors of its own or solve with them: in parallel, begun in
/// this order, where the BLAS allows it, else one after the other. Debian's serial OpenBLAS does not, as its calls share
/// buffers; its pthread one does. SparseCholesky::factorize() calls no BLAS: what does nothing else needs no such care.
void for_each_solve(Eigen::Index count, const std::function<void(Eigen::Index)>& visit);

/// A Cholesky factor's columns in groups with the same rows, as CHOLMOD stores them: of group s the columns starts[s]
/// .. starts[s + 1], its rows (diagonal ones first) from row_starts[s] on, values by columns from value_starts[s] on.
struct SupernodalColumns {
  std::vector<int> order;  // unknown at each rank
  std::vector<int> starts, row_starts, value_starts, rows;
  std::vector<double> values;
};

/// Factors a matrix given by its lower triangle, eliminated in this order (but subtrees put together). False if it is
/// not positive definite; throws std::bad_alloc.
bool factorize(const Eigen::SparseMatrix<double>& lower, std::vector<int> order, SupernodalColumns& columns);

}  // namespace umax
