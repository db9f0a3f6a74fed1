// The Cholesky factor A = L L^T of a small matrix whose columns end early, as those of a lattice's nodes do that stand
// layer by layer: stored dense, but rows below a column's last number, which stay zero in L, are passed over (envelope or
// skyline method: George and Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981).
#pragma once

#include <vector>

#include "core/base/types.h"

namespace umax {

struct EnvelopeCholesky {
  MatrixXd L;                      // its lower triangle; above, what A had
  std::vector<Eigen::Index> ends;  // of each block of columns: the row behind the last one in it or before it
  bool is_definite = true;         // false: A is not positive definite, and L no factor
};

/// Factors a symmetric matrix, of which the lower triangle is read.
EnvelopeCholesky make_envelope_cholesky(MatrixXd A);

/// x = L^-1 x; rows of x before `first` are zero.
void solve_lower(const EnvelopeCholesky& factor, Eigen::Ref<MatrixXd> x, Eigen::Index first = 0);

/// x = L^-T x.
void solve_upper(const EnvelopeCholesky& factor, Eigen::Ref<MatrixXd> x);

}  // namespace umax
