#include "tests/support/eigenvalues.h"

#include <Eigen/Eigenvalues>

namespace umax::test {

VectorXd eigenvalues(const MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd generalized_eigenvalues(const MatrixXd& A, const MatrixXd& B) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(A, B, Eigen::EigenvaluesOnly | Eigen::Ax_lBx).eigenvalues();
}

}  // namespace umax::test
