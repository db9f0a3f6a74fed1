// A multigrid's V-cycle and the parts that it consists of: smoothing, restriction, prolongation, the coarsest solve.
// The cycle of the saddle-point system (core/linear/saddle/saddle_point_multigrid.h) is made of the same parts.
#pragma once

#include "core/linear/multigrid/multigrid.h"

namespace umax {

/// x[0] = gain D^-1 b.
void jacobi_from_zero(MultigridLevel& level, const AlignedArray<float>& b, float gain);

/// The next level's b = P^T (b - A x).
void restrict_residual(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, int current);

/// x += P correction at free nodes.
void prolong(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& correction, int current);

/// A vector's values at the nodes of the last level, where that is factored, in its factor's order: 0 at those that are not
/// free. And the other way round, to the level's first array.
VectorXd dense_values(const Multigrid& multigrid, const AlignedArray<float>& vector);
AlignedArray<float>& set_dense_values(const VectorXd& values, Multigrid& multigrid);

/// One V-cycle from this level on: x ~ A^-1 b, in one of the level's two arrays; `product` becomes b . x, but where the
/// level is the last one and factored.
AlignedArray<float>& v_cycle(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, double& product);

}  // namespace umax
