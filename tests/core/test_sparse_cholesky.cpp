#include "core/sparse_cholesky.h"

#include "core/elastic_energy.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

Model test_model() {
  Body body = test::make_block({5, 4, 3}, Vector3d::Zero(), 0.1);
  body.fixed_nodes = {0, 1, 2, 3, 4, 5};
  return make_model({body}, {});
}

// mass + weight * stiffness at rest
SystemMatrix elastic_matrix(const Model& model, double weight) {
  SystemMatrix matrix = make_system_matrix(model);
  reset(matrix);
  add_mass(model.node_mass, 1, matrix);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    add_element(e, weight * model.shapes[model.hex_shape[e]].stiffness, matrix);
  return matrix;
}

MatrixXd random_columns(Eigen::Index rows, Eigen::Index columns) {
  Random random(31);
  MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = random.uniform(-1, 1);
  return m;
}

double residual(const SystemMatrix& matrix, const VectorXd& x, const VectorXd& b) {
  return (multiply(matrix, x) - b).norm() / b.norm();
}

}  // namespace

TEST_CASE("a solve leaves a residual of rounding size") {
  const Model model = test_model();
  const SystemMatrix matrix = elastic_matrix(model, 100);
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(matrix));
  const MatrixXd b = random_columns(matrix.num_unknowns(), 1);
  MatrixXd x = b;
  cholesky.solve(x);
  CHECK(residual(matrix, x, b) < 1e-12);
}

TEST_CASE("columns solved together are the columns solved one by one") {
  const Model model = test_model();
  const SystemMatrix matrix = elastic_matrix(model, 100);
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(matrix));
  const MatrixXd b = random_columns(matrix.num_unknowns(), 37);
  MatrixXd together = b;
  cholesky.solve(together);
  for (Eigen::Index c = 0; c < b.cols(); ++c) {
    MatrixXd alone = b.col(c);
    cholesky.solve(alone);
    CHECK((alone - together.col(c)).norm() < 1e-12 * alone.norm());
  }
  // part of a wider matrix, in place
  MatrixXd wide = b;
  cholesky.solve(wide.middleCols(3, 5));
  CHECK((wide.middleCols(3, 5) - together.middleCols(3, 5)).norm() < 1e-12 * together.norm());
  CHECK(wide.rightCols(29) == b.rightCols(29));
}

TEST_CASE("a matrix that is not positive definite is reported, and the next one solves again") {
  const Model model = test_model();
  SparseCholesky cholesky;
  const SystemMatrix good = elastic_matrix(model, 100), bad = elastic_matrix(model, -100);
  CHECK_FALSE(cholesky.factorize(bad));
  REQUIRE(cholesky.factorize(good));
  const MatrixXd b = random_columns(good.num_unknowns(), 2);
  MatrixXd x = b;
  cholesky.solve(x);
  CHECK(residual(good, x.col(0), b.col(0)) < 1e-12);
  CHECK_FALSE(cholesky.factorize(bad));
  REQUIRE(cholesky.factorize(good));
  MatrixXd again = b;
  cholesky.solve(again);
  CHECK(again == x);
}

TEST_CASE("a factor follows the matrix when its values change") {
  const Model model = test_model();
  SparseCholesky cholesky;
  for (const double weight : {1.0, 1e3, 10.0}) {
    const SystemMatrix matrix = elastic_matrix(model, weight);
    REQUIRE(cholesky.factorize(matrix));
    const MatrixXd b = random_columns(matrix.num_unknowns(), 1);
    MatrixXd x = b;
    cholesky.solve(x);
    CHECK(residual(matrix, x, b) < 1e-11);
  }
}
