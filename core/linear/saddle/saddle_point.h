// The solver of linear systems with rank-one terms,  (A + G G^T) x = b + G c,  in the form of a saddle point (Benzi,
// Golub, Liesen 2005, Numerical solution of saddle point problems)
//
//   [ A    G ] [x]   [b]
//   [ G^T -I ] [y] = [c]
//
// with conjugate residuals, preconditioned by its multigrid (core/linear/saddle/saddle_point_multigrid.h): generalised,
// as the cycle is no symmetric matrix, and truncated (Eisenstat, Elman, Schultz 1983). Where a residual's direction leads
// nowhere, the next one is that of the last image, as in Arnoldi's method. The count of iterations depends little on
// how stiff the terms G are, and on the number of hexes.
#pragma once

#include <array>

#include "core/linear/saddle/saddle_point_multigrid.h"

namespace umax {

struct SaddlePointOptions {
  double tolerance = 1e-3;  // [-] fall of the error in the matrix's norm, from the largest since begin()
  double reduction = 0;     // [-] or its fall during this solve, whichever is reached first
  int max_iterations = 150;
};

struct SaddlePointReport {
  int iterations = 0;
  double started = 0;  // [-] the error as this solve began, from the largest since begin(), as the preconditioner tells
  double error = 0;    // [-] what it fell to
};

/// A solution on its way, and the memory that solve() works in.
struct SaddlePoint {
  struct Direction {
    AlignedArray<float> x, image;  // d, A d + G e of a direction (d, e)
    VectorXd y, term_image;        // e, G^T d - e; images of all directions are orthogonal
    double square = 0;             // of the image's norm
  };
  AlignedArray<float> x, residual;  // of the nodes; r = b - A x - G y
  VectorXd y, c, term_residual;     // of the terms: y = G^T x - c is as exact as x is, though G x would cancel
  double largest_error = 0;
  double error = 0;     // [-] that the last solve has left, from the largest
  bool pushed = false;  // has the residual been added to since the last solve?
  std::array<Direction, 8> directions;
  int num_directions = 0;  // so far: of the last ones each has its place in turn
};
SaddlePoint make_saddle_point(const Multigrid& multigrid);

/// x = 0 and b = 0.
void begin(const VectorXd& c, SaddlePoint& point);

/// Improves x and y with the finest level's matrix and the terms that set_up() has seen. Whoever adds to b adds to the
/// residual, zero at nodes that are not free, says so (pushed), and solves on: what solves before have left over is
/// made good by those that follow.
SaddlePointReport solve(Multigrid& multigrid, SaddlePointMultigrid& terms, const SaddlePointOptions& options,
                        SaddlePoint& point);

}  // namespace umax
