// How contacts give way to each other on multigrids, against dense algebra.
#include "core/step/bpx_contact_compliance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/resting_block.h"

using namespace umax;
using test::Resting;

TEST_CASE("the multilevel compliance is the Delassus matrix up to a small factor, and symmetric") {
  Resting resting;
  const BpxContactCompliance compliance = make_bpx_contact_compliance(resting.model, resting.system, resting.contacts);
  const Eigen::Index size = 3 * Eigen::Index(resting.contacts.size());
  MatrixXd nearly(size, size), J = MatrixXd::Zero(3 * resting.model.num_nodes(), size);
  for (Eigen::Index i = 0; i < size; ++i) {
    nearly.col(i) = apply(compliance, VectorXd::Unit(size, i));
    spread(resting.model, resting.contacts[std::size_t(i / 3)], Vector3d::Unit(i % 3), J.col(i));
  }
  CHECK((nearly - nearly.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * nearly.cwiseAbs().maxCoeff());
  const MatrixXd delassus = J.transpose() * resting.matrix().ldlt().solve(J);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(delassus, 0.5 * (nearly + nearly.transpose()),
                                                                 Eigen::EigenvaluesOnly);
  CHECK(eigen.eigenvalues().minCoeff() >= 0.1);
  CHECK(eigen.eigenvalues().maxCoeff() <= 3);
}

namespace {

MatrixXd matrix_of(const BpxContactCompliance& compliance, Eigen::Index size) {
  MatrixXd W(size, size);
  for (Eigen::Index i = 0; i < size; ++i) W.col(i) = apply(compliance, VectorXd::Unit(size, i));
  return W;
}

// what `count` random forces really do
void learn_random(Resting& resting, int count, BpxContactCompliance& compliance) {
  const Eigen::Index size = 3 * Eigen::Index(resting.contacts.size());
  MatrixXd J = MatrixXd::Zero(3 * resting.model.num_nodes(), size);
  for (Eigen::Index i = 0; i < size; ++i)
    spread(resting.model, resting.contacts[std::size_t(i / 3)], Vector3d::Unit(i % 3), J.col(i));
  const MatrixXd delassus = J.transpose() * resting.matrix().ldlt().solve(J);
  test::Random random(11);
  for (int n = 0; n < count; ++n) {
    VectorXd force(size);
    for (double& value : force) value = random.uniform(-1, 1);
    learn(force, delassus * force, compliance);
    CHECK((apply(compliance, force) - delassus * force).norm() <= 1e-9 * (delassus * force).norm());
  }
}

}  // namespace

TEST_CASE("a compliance that has learnt responses gives them again, and stays symmetric and positive definite") {
  Resting resting;
  BpxContactCompliance compliance = make_bpx_contact_compliance(resting.model, resting.system, resting.contacts);
  learn_random(resting, 12, compliance);
  CHECK(compliance.forces.cols() == 8);  // the last ones
  const MatrixXd W = matrix_of(compliance, 3 * Eigen::Index(resting.contacts.size()));
  CHECK((W - W.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * W.cwiseAbs().maxCoeff());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(W, Eigen::EigenvaluesOnly);
  CHECK(eigen.eigenvalues().minCoeff() > 0);

  const VectorXd again = compliance.forces.col(7);
  learn(again, compliance.responses.col(7), compliance);  // nothing new: told twice
  CHECK((apply(compliance, again) - compliance.responses.rightCols(1)).norm() <= 1e-9);
}

TEST_CASE("contacts on the multilevel compliance are solved as on its matrix, be it made or not") {
  Resting resting;
  if (GENERATE(false, true))  // every other one is between two points of the body, which it pushes apart
    for (std::size_t i = 0; i + 1 < resting.contacts.size(); i += 2) {
      resting.contacts[i].obstacle = -1;
      resting.contacts[i].other = resting.contacts[i + 1].support;
    }
  BpxContactCompliance compliance = make_bpx_contact_compliance(resting.model, resting.system, resting.contacts);
  REQUIRE(compliance.dense.rows() == 3 * Eigen::Index(resting.contacts.size()));
  const MatrixXd unmeasured = matrix_of(compliance, compliance.dense.rows());
  CHECK((compliance.dense - unmeasured).cwiseAbs().maxCoeff() <= 1e-6 * unmeasured.cwiseAbs().maxCoeff());
  if (GENERATE(false, true)) compliance.dense.resize(0, 0);  // as of many contacts
  const Eigen::Index size = 3 * Eigen::Index(resting.contacts.size());
  learn_random(resting, GENERATE(0, 3), compliance);
  ComplementarityProblem problem;
  problem.W = matrix_of(compliance, size);
  test::Random random(5);
  problem.q.resize(size);
  for (double& value : problem.q) value = random.uniform(-2, 1) * 1e-3;
  for (const Contact& contact : resting.contacts) problem.contacts.push_back({contact.normal, contact.friction, 0});
  VectorXd expected = VectorXd::Zero(size), forces = expected;
  REQUIRE(gauss_seidel(problem, {.max_sweeps = 20000, .tolerance = 1e-10}, expected).converged);
  solve_contacts(compliance, problem.contacts, problem.q, {.max_sweeps = 20000, .tolerance = 1e-10}, forces);
  CHECK(expected.maxCoeff() > 0);
  CHECK((forces - expected).cwiseAbs().maxCoeff() <= 1e-5 * expected.cwiseAbs().maxCoeff());
}
