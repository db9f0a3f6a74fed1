// The single-precision factor for many solves, against Eigen's.
#include "core/linear/direct/supernodal_factor.h"

#include <tbb/global_control.h>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <cmath>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;

namespace {

// the lower triangle of a discrete Laplacian of n^3 points, plus the identity; every `cut`-th plane stands apart
Eigen::SparseMatrix<double> laplacian(int n, int cut, double shift = 1) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto index = [&](int i, int j, int k) { return (i * n + j) * n + k; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const int at = index(i, j, k);
        entries.emplace_back(at, at, 6 + shift);
        if (k > 0) entries.emplace_back(at, index(i, j, k - 1), -1);
        if (j > 0) entries.emplace_back(at, index(i, j - 1, k), -1);
        if (i > 0 && i % cut != 0) entries.emplace_back(at, index(i - 1, j, k), -1);
      }
  Eigen::SparseMatrix<double> matrix(n * n * n, n * n * n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::vector<int> order_of(const Eigen::SparseMatrix<double>& lower) {
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), permutation);
  return {permutation.indices().data(), permutation.indices().data() + permutation.indices().size()};
}

VectorXd random_vector(Eigen::Index size) {
  test::Random random(4);
  VectorXd b(size);
  for (double& value : b) value = random.uniform(-1, 1);
  return b;
}

}  // namespace

TEST_CASE("a supernodal factor solves small and large systems, connected or not, as Eigen does") {
  const int n = GENERATE(1, 2, 9, 17);
  const int cut = GENERATE(4, 1000);
  CAPTURE(n, cut);
  const Eigen::SparseMatrix<double> lower = laplacian(n, cut);
  const VectorXd b = random_vector(lower.rows());
  SupernodalFactor factor;
  REQUIRE(factorize(lower, order_of(lower), factor));
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> reference(lower);
  const VectorXd expected = reference.solve(b);
  CHECK((solve(factor, b) - expected).norm() <= 1e-6 * expected.norm());
  int covered = int(factor.top.size());
  for (const auto& [first, end] : factor.subtrees) covered += end - first;
  CHECK(covered == int(factor.supernodes.size()));
  if (n == 17) CHECK(factor.subtrees.size() >= 8);
}

TEST_CASE("a supernodal factor solves to the same bits with one thread and with two") {
  SupernodalFactor factor;
  const Eigen::SparseMatrix<double> lower = laplacian(16, 1000);
  REQUIRE(factorize(lower, order_of(lower), factor));
  const VectorXd b = random_vector(lower.rows());
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  const VectorXd with_two = solve(factor, b);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  CHECK(solve(factor, b) == with_two);
}

TEST_CASE("a matrix that is not positive definite has no supernodal factor") {
  SupernodalFactor factor;
  const Eigen::SparseMatrix<double> lower = laplacian(6, 1000, -3);
  CHECK_FALSE(factorize(lower, order_of(lower), factor));
}
