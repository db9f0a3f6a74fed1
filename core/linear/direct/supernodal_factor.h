// The Cholesky factor of a sparse matrix for very many solves with one right-hand side each, as preconditioners need:
// single precision, independent subtrees of the elimination tree in parallel, products instead of triangular solves
// (selective inversion, Raghavan 1998; supernodes: Davis, Direct Methods for Sparse Linear Systems, 2006).
//
// L in supernodes, columns with the same rows below them. Of each: L_11^-1 and L_21, dense.
//   forward   y_1 = L_11^-1 b_1,  b_2 -= L_21 y_1;      backward   x_1 = L_11^-T (y_1 - L_21^T x_2)
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "core/base/types.h"

namespace umax {

struct SupernodalFactor {
  struct Supernode {
    int first = 0, size = 0;       // columns
    int rows_first = 0, rows = 0;  // below, in row_indices
    std::size_t values = 0;        // where L_11^-1 begins (size x size), then L_21 (rows x size), by columns
  };
  std::vector<Supernode> supernodes;  // in postorder: subtrees stand together
  std::vector<int> row_indices;
  std::vector<float> values;
  std::vector<int> order;                     // unknown at each rank
  std::vector<std::pair<int, int>> subtrees;  // [first, end) of supernodes that depend on none outside
  std::vector<int> top;                       // all others, ascending
  std::vector<int> top_index;                 // per rank: its number among the unknowns of `top`, or -1
  int num_top = 0;
};

/// Factors a matrix given by its lower triangle, with the unknowns eliminated in this order. False if it is not
/// positive definite in double precision; throws std::bad_alloc.
bool factorize(const Eigen::SparseMatrix<double>& lower, std::vector<int> order, SupernodalFactor& factor);

/// A^-1 b, to single precision; the same bits for any number of threads.
VectorXd solve(const SupernodalFactor& factor, const VectorXd& b);

}  // namespace umax
