#include "core/linear/direct/sparse_cholesky.h"

#include <algorithm>
#include <csignal>
#include <thread>

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

TEST_CASE("half columns of forces at a few nodes multiply to what the inverse says") {
  const Model model = test_model();
  const auto last = GENERATE(std::vector<int>{}, std::vector<int>{8, 9, 10, 11, 60, 61, 62, 63, 100});
  CAPTURE(last.size());
  SystemMatrix matrix = make_system_matrix(model, last);
  reset(matrix);
  add_mass(model.node_mass, 1, matrix);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    add_element(e, 100 * model.shapes[model.hex_shape[e]].stiffness, matrix);
  SparseCholesky cholesky;
  REQUIRE(cholesky.factorize(matrix));

  Random random(5);
  const Eigen::Index count = 12, num_first = 5;
  MatrixXd b = MatrixXd::Zero(matrix.num_unknowns(), count);
  std::vector<SparseEntry> first, second;
  for (int c = 0; c < count; ++c)
    for (int i = 0; i < 3; ++i) {  // nodes far apart, one of them twice
      const int node = (37 * c + 50 * (i % 2)) % int(model.num_nodes());
      const double value = random.uniform(-1, 1);
      b(3 * node + i, c) += value;
      const bool is_first = c < num_first;
      (is_first ? first : second).push_back({3 * matrix.ranks[node] + i, is_first ? c : c - int(num_first), value});
    }
  MatrixXd solved = b;
  cholesky.solve(solved);
  const MatrixXd compliance = b.transpose() * solved;
  const HalfColumns one = half_solve(cholesky.columns(), first, num_first),
                    two = half_solve(cholesky.columns(), second, count - num_first);
  MatrixXd W(count, count);
  W << products(one), products(one, two), products(two, one), products(two);
  CHECK((W - compliance).norm() <= 1e-12 * compliance.norm());
  // and with what reaches every unknown, as halves of a solve
  const auto numbers = [&](Eigen::Index size) -> VectorXd {
    return VectorXd::NullaryExpr(size, [&](Eigen::Index) { return random.uniform(-1, 1); });
  };
  const VectorXd full = numbers(matrix.num_unknowns()), half = cholesky.solve_forward(full);
  VectorXd whole = full;
  cholesky.solve(whole);
  CHECK((cholesky.solve_backward(half) - whole).norm() <= 1e-14 * whole.norm());
  VectorXd by_columns(count), forces = numbers(count), sum = half;
  by_columns << products(cholesky.columns(), one, half), products(cholesky.columns(), two, half);
  CHECK((by_columns - b.transpose() * whole).norm() <= 1e-12 * by_columns.norm());
  add_columns(cholesky.columns(), one, forces.head(num_first), sum);
  add_columns(cholesky.columns(), two, forces.tail(count - num_first), sum);
  whole += solved * forces;
  CHECK((cholesky.solve_backward(sum) - whole).norm() <= 1e-12 * whole.norm());
  Eigen::Index held = 0, all = 0;  // columns do not reach everything
  for (const HalfColumns::Group& group : one.groups) held += group.values.size();
  for (int s = 0; s < cholesky.columns().num_groups; ++s)
    all += num_first * (cholesky.columns().starts[s + 1] - cholesky.columns().starts[s]);
  CHECK(held < all);
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

TEST_CASE("orders that are found at the same time are the one that is found alone, and signals stay whose they were") {
  const Model model = make_model({test::make_block({13, 13, 13}, Vector3d::Zero(), 0.1)}, {});
  const auto order_of = [&] { return elimination_order(model.hexes, model.num_nodes(), {}); };
  const std::vector<int> alone = order_of();
  const auto handler = [] {
    const auto now = std::signal(SIGTERM, SIG_DFL);
    std::signal(SIGTERM, now);
    return now;
  };
  const auto before = handler();
  std::vector<std::vector<int>> together(4);
  std::vector<std::thread> threads;
  for (std::vector<int>& order : together) threads.emplace_back([&] { order = order_of(); });
  for (std::thread& thread : threads) thread.join();
  const auto same = std::count(together.begin(), together.end(), alone);
  CHECK(same == 4);
  CHECK(handler() == before);
}
