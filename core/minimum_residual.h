// Minimum residuals (MINRES) for  (A + G G^T) x = b + G c  as the saddle-point system
//
//   [ A    G ] [x]   [b]
//   [ G^T -I ] [y] = [c],   preconditioned by the multigrid for A and diag(1 + g^T A^-1 g) for the rest
// The count of iterations depends little on how stiff the terms G are. Paige and Saunders 1975; Elman, Silvester,
// Wathen (2014), Finite Elements and Fast Iterative Solvers, ch. 4.
#pragma once

#include "core/hex_terms.h"
#include "core/multigrid.h"

namespace umax {

struct MinimumResidualOptions {
  double tolerance = 1e-3;  // [-] fall of the residual in the preconditioner's norm
  int max_iterations = 300;
};

struct MinimumResidualReport {
  int iterations = 0;
  double residual = 0;  // [-] what it fell to
};

/// Memory that solve() works in.
struct MinimumResidualWorkspace {
  AlignedArray<float> residuals[3], step, directions[3];
};
MinimumResidualWorkspace make_residual_workspace(const Multigrid& multigrid);

/// Solves from x = 0 with the finest level's matrix, which set_up() has seen; b is zero at nodes that are not free.
/// y = G^T x - c is as exact as x is, though G x would cancel.
MinimumResidualReport solve(Multigrid& multigrid, const HexTerms& terms, const MinimumResidualOptions& options,
                            const AlignedArray<float>& b, const VectorXd& c, MinimumResidualWorkspace& workspace,
                            AlignedArray<float>& x, VectorXd& y);

}  // namespace umax
