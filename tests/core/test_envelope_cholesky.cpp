// The factor of a matrix whose columns end early, against Eigen's dense one.
#include "core/linear/multigrid/envelope_cholesky.h"

#include <Eigen/Cholesky>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;

namespace {

MatrixXd random_matrix(test::Random& random, Eigen::Index rows, Eigen::Index columns) {
  MatrixXd matrix(rows, columns);
  for (double& value : matrix.reshaped()) value = random.uniform(-1, 1);
  return matrix;
}

// positive definite; `reach`: how far below the diagonal a column has numbers
MatrixXd banded(Eigen::Index size, Eigen::Index reach) {
  test::Random random(5);
  MatrixXd A = random_matrix(random, size, size);
  A = (A + A.transpose()).eval();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j)
      if (std::abs(i - j) > reach) A(i, j) = 0;
  A.diagonal().array() += 4.0 * double(std::min(size, reach + 1));
  return A;
}

double error_of(const MatrixXd& found, const MatrixXd& expected) {
  return (found - expected).norm() / expected.norm();
}

}  // namespace

TEST_CASE("an envelope factor is that of a dense matrix, and solves in halves as it does") {
  const Eigen::Index size = GENERATE(1, 23, 24, 25, 150), reach = GENERATE(0, 3, 40, 1000);
  CAPTURE(size, reach);
  MatrixXd A = banded(size, reach);
  if (size > 30) A(29, 2) = A(2, 29) = 0.5;  // reaches farther than columns behind it
  const Eigen::LLT<MatrixXd> reference(A);
  const EnvelopeCholesky factor = make_envelope_cholesky(A);
  REQUIRE(factor.is_definite);
  CHECK(error_of(factor.L.triangularView<Eigen::Lower>(), reference.matrixL()) <= 1e-13);

  test::Random random(6);
  const MatrixXd b = random_matrix(random, size, 5);
  MatrixXd x = b;
  solve_lower(factor, x);
  CHECK(error_of(x, reference.matrixL().solve(b)) <= 1e-13);
  solve_upper(factor, x);
  CHECK(error_of(A * x, b) <= 1e-12);
  VectorXd single = b.col(0);
  solve_lower(factor, single);
  solve_upper(factor, single);
  CHECK(error_of(single, x.col(0)) <= 1e-13);
}

TEST_CASE("an envelope factor begins to solve where the right-hand side does") {
  const EnvelopeCholesky factor = make_envelope_cholesky(banded(150, 40));
  for (const Eigen::Index first : {0, 30, 77, 149}) {
    CAPTURE(first);
    VectorXd whole = VectorXd::Zero(150);
    whole[first] = 1;
    VectorXd late = whole;
    solve_lower(factor, whole);
    solve_lower(factor, late, first);
    CHECK(whole == late);
  }
}

TEST_CASE("an envelope factor passes over what its columns do not reach, and says where a matrix is not definite") {
  CHECK(make_envelope_cholesky(banded(150, 3)).ends == std::vector<Eigen::Index>{27, 51, 75, 99, 123, 147, 150});
  MatrixXd A = banded(60, 3);
  A(40, 40) = -1;
  CHECK_FALSE(make_envelope_cholesky(A).is_definite);
}
