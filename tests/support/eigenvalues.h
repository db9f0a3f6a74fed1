// Eigenvalues of symmetric matrices, compiled once: Eigen's solvers take a compiler seconds for every size.
#pragma once

#include "core/base/types.h"

namespace umax::test {

/// Ascending.
VectorXd eigenvalues(const MatrixXd& symmetric);

/// lambda of A x = lambda B x for positive B, ascending.
VectorXd generalized_eigenvalues(const MatrixXd& A, const MatrixXd& B);

}  // namespace umax::test
