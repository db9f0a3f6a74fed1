#include "core/contact/gauss_seidel.h"

#include <Eigen/Dense>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

MatrixXd random_positive_definite(Random& random, int n) {
  MatrixXd factor(n, n + 2);
  for (Eigen::Index i = 0; i < factor.size(); ++i) factor.data()[i] = random.uniform(-1, 1);
  return factor * factor.transpose() + 0.05 * MatrixXd::Identity(n, n);
}

VectorXd random_vector(Random& random, int n) {
  VectorXd v(n);
  for (int i = 0; i < n; ++i) v[i] = random.uniform(-1, 1);
  return v;
}

ComplementarityProblem make_problem(const MatrixXd& W, const VectorXd& q) {
  ComplementarityProblem problem;
  problem.W = W;
  problem.q = q;
  return problem;
}

// the one solution of 0 <= z perp W z + q >= 0, found by trying all active sets
VectorXd enumerate(const MatrixXd& W, const VectorXd& q) {
  const int n = int(q.size());
  for (int set = 0; set < 1 << n; ++set) {
    std::vector<int> active;
    for (int i = 0; i < n; ++i)
      if (set >> i & 1) active.push_back(i);
    VectorXd z = VectorXd::Zero(n);
    if (!active.empty()) {
      const VectorXd solution = MatrixXd(W(active, active)).ldlt().solve(-VectorXd(q(active)));
      z(active) = solution;
    }
    const VectorXd w = W * z + q;
    if (z.minCoeff() >= -1e-12 && w.minCoeff() >= -1e-9) return z;
  }
  FAIL("a positive definite complementarity problem has a solution");
  return {};
}

// how far z is from Signorini's and Coulomb's laws, each in its own unit
double law_violation(const ComplementarityProblem& problem, const VectorXd& z) {
  const VectorXd w = problem.W * z + problem.q;
  double worst = 0;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactRow& contact = problem.contacts[i];
    const Vector3d n = contact.normal, impulse = z.segment<3>(3 * i), velocity = w.segment<3>(3 * i);
    const double normal_impulse = n.dot(impulse), normal_velocity = n.dot(velocity) + contact.bias;
    const Vector3d friction = impulse - normal_impulse * n, sliding = velocity - n.dot(velocity) * n;
    const double slack = contact.friction * normal_impulse - friction.norm();
    worst = std::max({worst, -normal_impulse, -normal_velocity, -slack});
    worst = std::max(worst, std::min(std::abs(normal_impulse), std::abs(normal_velocity)));
    // inside the cone it sticks; on it, friction opposes the sliding
    if (slack > 1e-4) worst = std::max(worst, sliding.norm());
    worst = std::max(worst, (sliding * friction.norm() + friction * sliding.norm()).norm());
  }
  return worst;
}

constexpr GaussSeidelOptions tight{.max_sweeps = 200000, .tolerance = 1e-13};

}  // namespace

TEST_CASE("Gauss-Seidel finds the solution that enumerating all active sets finds") {
  Random random(11);
  for (int trial = 0; trial < 40; ++trial) {
    const int n = 1 + trial % 8;
    ComplementarityProblem problem = make_problem(random_positive_definite(random, n), random_vector(random, n));
    problem.num_limits = n;
    VectorXd z = VectorXd::Zero(n);
    CHECK(gauss_seidel(problem, tight, z).converged);
    CHECK((z - enumerate(problem.W, problem.q)).norm() < 1e-8);
  }
}

TEST_CASE("frictionless contacts and limits together solve the same problem along the normals") {
  Random random(12);
  for (int trial = 0; trial < 20; ++trial) {
    const int contacts = 1 + trial % 3, limits = trial % 4, rows = 3 * contacts + limits;
    ComplementarityProblem problem = make_problem(random_positive_definite(random, rows), random_vector(random, rows));
    problem.num_limits = limits;
    // N maps a scalar per contact and limit onto the rows
    MatrixXd N = MatrixXd::Zero(rows, contacts + limits);
    VectorXd bias = VectorXd::Zero(contacts + limits);
    for (int i = 0; i < contacts; ++i) {
      problem.contacts.push_back({random.vector(1).normalized(), 0, random.uniform(-0.5, 0.5)});
      N.col(i).segment<3>(3 * i) = problem.contacts[i].normal;
      bias[i] = problem.contacts[i].bias;
    }
    N.bottomRightCorner(limits, limits).setIdentity();
    VectorXd z = VectorXd::Zero(rows);
    CHECK(gauss_seidel(problem, tight, z).converged);
    const VectorXd oracle = enumerate(N.transpose() * problem.W * N, N.transpose() * problem.q + bias);
    CHECK((z - N * oracle).norm() < 1e-8);
  }
}

TEST_CASE("frictional contacts obey the laws of Signorini and Coulomb") {
  Random random(13);
  for (int trial = 0; trial < 40; ++trial) {
    const int contacts = 1 + trial % 4;
    ComplementarityProblem problem = make_problem(
        random_positive_definite(random, 3 * contacts) + 4 * MatrixXd::Identity(3 * contacts, 3 * contacts),
        random_vector(random, 3 * contacts));
    for (int i = 0; i < contacts; ++i)
      problem.contacts.push_back({random.vector(1).normalized(), random.uniform(0, 1), random.uniform(-1, 0.2)});
    VectorXd z = VectorXd::Zero(3 * contacts);
    CHECK(gauss_seidel(problem, tight, z).converged);
    CHECK(law_violation(problem, z) < 1e-7);
  }
}

TEST_CASE("a point mass sticks inside the cone and slides on it against its motion") {
  // W = 1/m, q = velocity after gravity pulled: known in closed form
  ComplementarityProblem problem = make_problem(MatrixXd::Identity(3, 3) / 2.0, VectorXd::Zero(3));
  problem.contacts.push_back({Vector3d::UnitY(), 0.5, 0});
  VectorXd z = VectorXd::Zero(3);
  SECTION("sticks") {
    problem.q << 0.3, -1, -0.2;
    gauss_seidel(problem, tight, z);
    CHECK((z - Vector3d(-0.6, 2, 0.4)).norm() < 1e-10);
  }
  SECTION("slides") {
    problem.q << 3, -1, -4;
    gauss_seidel(problem, tight, z);
    CHECK((z - Vector3d(-0.6, 2, 0.8)).norm() < 1e-10);
  }
  SECTION("separates") {
    problem.q << 3, 1, -4;
    gauss_seidel(problem, tight, z);
    CHECK(z.norm() == 0);
  }
}

TEST_CASE("a warm start changes the sweeps, not the solution") {
  Random random(14);
  ComplementarityProblem problem = make_problem(random_positive_definite(random, 12), random_vector(random, 12));
  problem.num_limits = 12;
  VectorXd cold = VectorXd::Zero(12);
  const GaussSeidelResult first = gauss_seidel(problem, tight, cold);
  VectorXd warm = cold;
  const GaussSeidelResult again = gauss_seidel(problem, tight, warm);
  CHECK(again.sweeps < first.sweeps);
  CHECK((warm - cold).norm() < 1e-10);
  VectorXd far = VectorXd::Constant(12, 100.0);
  gauss_seidel(problem, tight, far);
  CHECK((far - cold).norm() < 1e-8);
}

TEST_CASE("the sweep limit is kept and reported") {
  Random random(15);
  ComplementarityProblem problem = make_problem(random_positive_definite(random, 8), VectorXd::Constant(8, -1.0));
  problem.num_limits = 8;
  VectorXd z = VectorXd::Zero(8);
  const GaussSeidelResult result = gauss_seidel(problem, {.max_sweeps = 2, .tolerance = 1e-13}, z);
  CHECK(result.sweeps == 2);
  CHECK_FALSE(result.converged);
}

TEST_CASE("the friction disc keeps what lies inside and shortens what lies outside") {
  CHECK(project_to_disc({0.3, 0, 0.4}, 1) == Vector3d(0.3, 0, 0.4));
  CHECK((project_to_disc({3, 0, 4}, 1) - Vector3d(0.6, 0, 0.8)).norm() < 1e-15);
  CHECK(project_to_disc({3, 0, 4}, 0) == Vector3d::Zero());
  CHECK(project_to_disc(Vector3d::Zero(), 0) == Vector3d::Zero());
}
