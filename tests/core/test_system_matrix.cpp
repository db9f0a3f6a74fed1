#include "core/linear/direct/system_matrix.h"

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/matrix_product.h"

using namespace umax;
using test::Random;

namespace {

Matrix24d random_symmetric(Random& random) {
  Matrix24d m;
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j <= i; ++j) m(i, j) = m(j, i) = random.uniform(-1, 1);
  return m;
}

Model branched_model(const std::vector<int>& fixed) {
  Cells cells(5, 3);
  cells << 0, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1, 1, 2, 2, 2;  // faces, and one corner only
  Body body;
  body.name = "branched";
  body.lattice = make_lattice(cells, Vector3d::Zero(), Vector3d::Ones());
  body.fixed_nodes = fixed;
  body.surface.weights.resize(0, 8);
  return make_model({body}, {});
}

// the sum of all parts as a full matrix: the oracle
struct DenseSum {
  const Model& model;
  MatrixXd values;
  explicit DenseSum(const Model& m) : model(m), values(MatrixXd::Zero(3 * m.num_nodes(), 3 * m.num_nodes())) {
    for (Eigen::Index i = 0; i < values.rows(); ++i)
      if (model.node_fixed[i / 3]) values(i, i) = 1;
  }
  void add(Eigen::Index row, Eigen::Index column, double value) {
    if (!model.node_fixed[row / 3] && !model.node_fixed[column / 3]) values(row, column) += value;
  }
  void add_element(Eigen::Index hex, const Matrix24d& element) {
    for (int i = 0; i < 24; ++i)
      for (int j = 0; j < 24; ++j)
        add(3 * model.hexes(hex, i / 3) + i % 3, 3 * model.hexes(hex, j / 3) + j % 3, element(i, j));
  }
};

}  // namespace

TEST_CASE("the sparse matrix is the sum of its element matrices and masses") {
  const auto fixed = GENERATE(std::vector<int>{}, std::vector<int>{0}, std::vector<int>{3, 7, 20});
  const Model model = branched_model(fixed);
  Random random(21);
  SystemMatrix matrix = make_system_matrix(model);
  for (int round = 0; round < 2; ++round) {  // the second round must not see the first
    DenseSum dense(model);
    reset(matrix);
    add_mass(model.node_mass, 2.5, matrix);
    for (Eigen::Index i = 0; i < 3 * model.num_nodes(); ++i) dense.add(i, i, 2.5 * model.node_mass[i / 3]);
    for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
      const Matrix24d element = random_symmetric(random);
      add_element(e, element, matrix);
      dense.add_element(e, element);
    }
    VectorXd x(3 * model.num_nodes());
    for (double& value : x) value = random.uniform(-1, 1);
    CHECK((test::multiply(matrix, x) - dense.values * x).norm() < 1e-12 * (dense.values * x).norm());
  }
}

TEST_CASE("columns begin with their diagonal and ascend") {
  const SystemMatrix matrix = make_system_matrix(branched_model({}));
  for (int column = 0; column < matrix.num_unknowns(); ++column) {
    const int begin = matrix.column_starts[column], end = matrix.column_starts[column + 1];
    REQUIRE(end > begin);
    CHECK(matrix.row_indices[begin] == column);
    for (int k = begin + 1; k < end; ++k) CHECK(matrix.row_indices[k] > matrix.row_indices[k - 1]);
  }
}

TEST_CASE("a fixed node neither moves nor moves others") {
  const Model model = branched_model({5});
  SystemMatrix matrix = make_system_matrix(model);
  Random random(22);
  reset(matrix);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) add_element(e, random_symmetric(random), matrix);
  VectorXd x = VectorXd::Zero(3 * model.num_nodes());
  x.segment<3>(15) << 1, 2, 3;
  CHECK((test::multiply(matrix, x) - x).norm() == 0);
}
