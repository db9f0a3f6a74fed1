// Conjugate gradients with the multigrid preconditioner: in float, with the residual computed anew in double each time
// that it has fallen a thousandfold, so that the solution is as exact as one found in double.
#pragma once

#include "core/linear/multigrid/multigrid.h"

namespace umax::test {

struct ConjugateGradientOptions {
  double tolerance = 1e-6;   // [-] on |b - A x| / |b|, checked in double
  int max_iterations = 500;  // preconditioned ones
};

struct ConjugateGradientReport {
  int iterations = 0;
  double residual = 0;  // |b - A x| / |b|, in double
  bool converged = false;
};

/// Memory that solve() works in.
struct ConjugateGradientWorkspace {
  AlignedArray<float> step, residual, direction;
};
ConjugateGradientWorkspace make_workspace(const Multigrid& multigrid);

/// Solves A x = b from x = 0 with the finest level's matrix, which set_up() has seen; b is zero at nodes that are not
/// free. `exact`, if given, is the same matrix in double: without it A is as exact as its values in float are.
ConjugateGradientReport solve(Multigrid& multigrid, const HexMatrix<double>* exact,
                              const ConjugateGradientOptions& options, const AlignedArray<double>& b,
                              ConjugateGradientWorkspace& workspace, AlignedArray<double>& x);

}  // namespace umax::test
