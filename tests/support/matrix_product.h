// Products with the assembled matrix of a step, for checking solutions.
#pragma once

#include "core/linear/direct/system_matrix.h"

namespace umax::test {

/// y = A x for x of 3 #N.
VectorXd multiply(const SystemMatrix& matrix, const VectorXd& x);

}  // namespace umax::test
