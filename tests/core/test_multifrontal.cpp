// The numeric factorisation of the direct solver: its dense kernels and their order, against Eigen's dense factor.
#include "core/linear/direct/multifrontal.h"

#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <vector>

#include "core/linear/direct/front_kernel.h"
#include "core/linear/direct/sparse_cholesky.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

/// Symmetric, eigenvalues from 1 on.
MatrixXd positive_matrix(int size) {
  Random random(std::size_t(17 + size));
  MatrixXd root(size, size);
  for (double& value : root.reshaped()) value = random.uniform(-1, 1);
  return root * root.transpose() + MatrixXd::Identity(size, size);
}

/// A front in memory of its own, which ends with it: address sanitizers see what a kernel does beyond.
struct OwnFront {
  std::vector<double> values;
  Front front;

  explicit OwnFront(const MatrixXd& matrix) {
    front.size = int(matrix.rows());
    front.stride = front_stride(front.size);
    values.assign(front.stride * std::size_t(front.size), 0.0);
    front.values = values.data();
    for (int j = 0; j < front.size; ++j)
      for (int i = j; i < front.size; ++i) values[std::size_t(j) * front.stride + std::size_t(i)] = matrix(i, j);
  }
  /// Its lower triangle.
  MatrixXd lower() const {
    MatrixXd matrix = MatrixXd::Zero(front.size, front.size);
    for (int j = 0; j < front.size; ++j)
      for (int i = j; i < front.size; ++i) matrix(i, j) = values[std::size_t(j) * front.stride + std::size_t(i)];
    return matrix;
  }
  bool is_zero_beyond() const {
    for (int j = 0; j < front.size; ++j)
      for (std::size_t i = std::size_t(front.size); i < front.stride; ++i)
        if (values[std::size_t(j) * front.stride + i] != 0) return false;
    return true;
  }
};

MatrixXd lower_part(const MatrixXd& matrix) {
  return matrix.triangularView<Eigen::Lower>();
}

/// A matrix of hexes that is positive definite, or is not at one node.
SystemMatrix hex_matrix(const Model& model, bool is_definite = true) {
  SystemMatrix matrix = make_system_matrix(model);
  reset(matrix);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    Random random(std::size_t(e + 1));
    Matrix24d root;
    for (double& value : root.reshaped()) value = random.uniform(-1, 1);
    add_element(e, root * root.transpose(), matrix);
  }
  VectorXd mass = VectorXd::Ones(model.num_nodes());
  if (!is_definite) mass[model.num_nodes() / 2] = -1e4;
  add_mass(mass, 1, matrix);
  return matrix;
}

MatrixXd dense_lower(const SystemMatrix& matrix) {
  MatrixXd dense = MatrixXd::Zero(matrix.num_unknowns(), matrix.num_unknowns());
  for (int c = 0; c < matrix.num_unknowns(); ++c)
    for (int i = matrix.column_starts[std::size_t(c)]; i < matrix.column_starts[std::size_t(c) + 1]; ++i)
      dense(matrix.row_indices[std::size_t(i)], c) = matrix.values[i];
  return dense;
}

MatrixXd dense_factor(const SupernodalView& factor, int size) {
  MatrixXd dense = MatrixXd::Zero(size, size);
  for (int g = 0; g < factor.num_groups; ++g) {
    const int rows = factor.row_starts[g + 1] - factor.row_starts[g];
    for (int c = factor.starts[g]; c < factor.starts[g + 1]; ++c)
      for (int r = c - factor.starts[g]; r < rows; ++r)
        dense(factor.rows[factor.row_starts[g] + r], c) =
            factor.values[factor.value_starts[g] + (c - factor.starts[g]) * rows + r];
  }
  return dense;
}

}  // namespace

TEST_CASE(
    "front kernels of every instruction set eliminate columns as Eigen does, and leave what is left of the rest") {
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    for (const int size : {1, 2, 3, 5, 6, 7, 9, 12, 24, 31, 32, 33, 57, 64, 100, 111})
      for (const int count : {1, 2, 3, 4, 6, 8, 13, 30, 57, 100}) {
        if (count > size) continue;
        CAPTURE(name_of(set), size, count);
        const MatrixXd matrix = positive_matrix(size);
        OwnFront own(matrix);
        const FrontKernels& kernels = front_kernels(set);
        const int half = count / 2;  // in two goes
        REQUIRE(kernels.eliminate(own.front, 0, half));
        kernels.update(own.front, 0, half, half, size);
        REQUIRE(kernels.eliminate(own.front, half, count - half));
        const int middle = count + (size - count) / 3;
        kernels.update(own.front, half, count - half, middle, size);
        kernels.update(own.front, half, count - half, count, middle);

        const MatrixXd L = MatrixXd(matrix.llt().matrixL());
        const MatrixXd left =
            matrix.bottomRightCorner(size - count, size - count) -
            L.bottomLeftCorner(size - count, count) * L.bottomLeftCorner(size - count, count).transpose();
        const MatrixXd now = own.lower();
        CHECK((now.leftCols(count) - L.leftCols(count)).norm() <= 1e-13 * matrix.norm());
        CHECK((now.bottomRightCorner(size - count, size - count) - lower_part(left)).norm() <= 1e-13 * matrix.norm());
        CHECK(own.is_zero_beyond());
      }
  }
}

TEST_CASE("front kernels see a matrix that is not positive definite, or no matrix of numbers") {
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
      CAPTURE(name_of(set), bad);
      MatrixXd matrix = MatrixXd::Identity(20, 20);
      matrix(13, 13) = bad;
      CHECK_FALSE(front_kernels(set).eliminate(OwnFront(matrix).front, 0, 20));
      CHECK(front_kernels(set).eliminate(OwnFront(matrix).front, 0, 13));
    }
  }
}

TEST_CASE("a factor of hexes is the dense one, and the same bits for any number of threads") {
  // a row of hexes, a block whose top front has several panels, two bodies
  std::vector<Model> models;
  models.push_back(make_model({test::make_block({30, 1, 1}, Vector3d::Zero(), 0.1)}, {}));
  models.push_back(make_model({test::make_block({8, 7, 6}, Vector3d::Zero(), 0.1)}, {}));
  models.push_back(make_model(
      {test::make_block({3, 3, 3}, Vector3d::Zero(), 0.1), test::make_block({4, 2, 2}, Vector3d(1, 0, 0), 0.1)}, {}));
  for (const Model& model : models) {
    const SystemMatrix matrix = hex_matrix(model);
    CAPTURE(matrix.num_unknowns());
    SparseCholesky cholesky;
    REQUIRE(cholesky.factorize(matrix));
    const MatrixXd L = dense_factor(cholesky.columns(), matrix.num_unknowns());
    const MatrixXd expected = dense_lower(matrix).selfadjointView<Eigen::Lower>().llt().matrixL();
    CHECK((L - expected).norm() <= 1e-12 * expected.norm());
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      for (int i = 0; i < 5; ++i) {
        REQUIRE(cholesky.factorize(matrix));
        CHECK(dense_factor(cholesky.columns(), matrix.num_unknowns()) == L);
      }
    }
  }
}

TEST_CASE("a matrix of hexes that is not positive definite anywhere is told from one that is") {
  const Model model = make_model({test::make_block({8, 7, 6}, Vector3d::Zero(), 0.1)}, {});
  SparseCholesky cholesky;
  CHECK_FALSE(cholesky.factorize(hex_matrix(model, false)));
  CHECK(dense_factor(cholesky.columns(), 3 * int(model.num_nodes())).isZero(0));
  const SystemMatrix good = hex_matrix(model);
  REQUIRE(cholesky.factorize(good));
  VectorXd x = VectorXd::Ones(good.num_unknowns());
  cholesky.solve(x);
  CHECK(x.allFinite());
}
