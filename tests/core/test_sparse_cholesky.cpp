#include "core/linear/direct/sparse_cholesky.h"

#include <algorithm>

#include "core/element/elastic_energy.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/matrix_product.h"

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
  return (test::multiply(matrix, x) - b).norm() / b.norm();
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

TEST_CASE("unknowns eliminated last have their compliance in a small factor of its own") {
  const Model model = test_model();
  const auto last =
      GENERATE(std::vector<int>{}, std::vector<int>{40}, std::vector<int>{8, 9, 10, 11, 60, 61, 62, 63, 100},
               std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8});
  CAPTURE(last.size());
  SystemMatrix matrix = make_system_matrix(model, last);
  reset(matrix);
  add_mass(model.node_mass, 1, matrix);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    add_element(e, 100 * model.shapes[model.hex_shape[e]].stiffness, matrix);
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(matrix));
  REQUIRE(cholesky.num_last() == 3 * int(last.size()));

  const Eigen::Index size = cholesky.num_last();
  MatrixXd everywhere = MatrixXd::Zero(matrix.num_unknowns(), size), here = MatrixXd::Zero(size, size);
  for (Eigen::Index k = 0; k < size; ++k) {
    const int node = last[std::size_t(k / 3)], axis = int(k % 3);
    everywhere(3 * node + axis, k) = 1;
    here(cholesky.last_row(node) + axis, k) = 1;
  }
  MatrixXd solved = everywhere;
  cholesky.solve(solved);
  cholesky.half_solve(everywhere);
  cholesky.half_solve_last(here);
  const MatrixXd compliance = everywhere.transpose() * everywhere;
  CHECK((here.transpose() * here - compliance).norm() <= 1e-12 * compliance.norm());
  for (Eigen::Index k = 0; k < size; ++k)
    CHECK(solved(3 * last[std::size_t(k / 3)] + k % 3, 0) == Approx(compliance(k, 0)).epsilon(1e-10));
  for (const int node : {12, 77})
    if (std::find(last.begin(), last.end(), node) == last.end()) CHECK(cholesky.last_row(node) == -1);
}

TEST_CASE("the elimination order holds every node once and keeps what is eliminated last together with its ancestors") {
  const Model model = test_model();
  const std::vector<int> last{20, 21, 90};
  const SystemMatrix matrix = make_system_matrix(model, last);
  std::vector<int> nodes = matrix.order;
  std::sort(nodes.begin(), nodes.end());
  for (std::size_t i = 0; i < nodes.size(); ++i) REQUIRE(nodes[i] == int(i));
  for (const int node : last) CHECK(matrix.ranks[node] >= int(nodes.size()) - 3);  // one connected body
}
