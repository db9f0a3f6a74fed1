// Conjugate gradients for  (A + G G^T) x = b + G c  as the saddle-point system
//
//   [ A    G ] [x]   [b]
//   [ G^T -I ] [y] = [c],   preconditioned by the multigrid for A and the terms' coupling for I + G^T A^-1 G
// Where the coupling is too large to be factored, one block of it per hex does. Multiplied by [A0^-1, 0; G^T A0^-1, -I]
// the system is symmetric and positive definite in the inner product with A - A0, if A0 = B^-1 / gamma is smaller than
// A, B the multigrid: gamma grows where that turns out to be wrong. The count of iterations depends little on how stiff
// the terms G are, and is half that of minimum residuals. Bramble and Pasciak 1988; Elman, Silvester, Wathen (2014),
// Finite Elements and Fast Iterative Solvers, ch. 4.
#pragma once

#include "core/hex_terms.h"
#include "core/multigrid.h"
#include "core/term_coupling.h"

namespace umax {

struct SaddlePointOptions {
  double tolerance = 1e-3;  // [-] fall of the residual in the inner product's norm, from the largest since begin()
  double reduction = 0;     // [-] or its fall during this solve, whichever is reached first
  int max_iterations = 300;
};

struct SaddlePointReport {
  int iterations = 0;
  double residual = 0;  // [-] what it fell to, from the largest since begin()
};

/// A solution on its way, and the memory that solve() works in.
struct SaddlePoint {
  AlignedArray<float> x, residual;  // of the nodes; r = b - A x - G y
  VectorXd y, c, term_residual;     // of the terms: y = G^T x - c is as exact as x is, though G x would cancel
  double gamma = 0;                 // A0 = B^-1 / gamma
  double largest_norm = 0;
  AlignedArray<float> solved, applied;                      // A0^-1 r, A A0^-1 r
  AlignedArray<float> direction, direction_applied, force;  // d, A d, A d + G e of the direction (d, e)
};
SaddlePoint make_saddle_point(const Multigrid& multigrid);

/// x = 0 and b = 0.
void begin(const VectorXd& c, SaddlePoint& point);

/// Improves x and y with the finest level's matrix, which set_up() has seen. Whoever adds to b adds to the residual,
/// zero at nodes that are not free, and solves on: what solves before have left over is made good by those that follow.
SaddlePointReport solve(Multigrid& multigrid, const HexTerms& terms, const TermCoupling& coupling,
                        const SaddlePointOptions& options, SaddlePoint& point);

}  // namespace umax
