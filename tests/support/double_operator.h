// The matrix-free operator in double: the library's own loops, compiled for tests and benchmarks, which thus see more
// than what single precision rounds away.
#pragma once

#include "core/linear/bricks/hex_operator.h"

namespace umax::test {

/// out = A x; returns x . A x. S: what the matrix is stored as.
template <class S>
double apply(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& x,
             AlignedArray<double>& out);

/// out = b - A x; returns its squared norm (before rounding to float).
template <class S>
double residual(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& b,
                const AlignedArray<double>& x, AlignedArray<float>& out);

}  // namespace umax::test
