// Contact forces by sweeps and Newton steps, against sweeps alone on the same problem as one dense matrix.
#include "core/step/contact_forces.h"

#include "core/step/contact_part.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

// A row of bodies, each of which has so many contacts with the next, as compliances of random points; some nearly alike, as
// where both surfaces' vertices touch at one place.
// softness: of what bodies give way beside their six rigid motions; little makes all forces depend on each other.
Delassus random_delassus(Random& random, int bodies, int count, double alikeness, double softness) {
  Delassus delassus;
  delassus.bodies.resize(std::size_t(bodies));
  for (int i = 0; i < (bodies - 1) * count; ++i) {
    for (const int side : {0, 1}) {
      const int body = i / count + side;
      std::vector<Support>& points = delassus.bodies[std::size_t(body)].points;
      delassus.sides.push_back({body, int(points.size()), side == 0 ? 1.0 : -1.0});
      points.emplace_back();
    }
    delassus.first_side.push_back(int(delassus.sides.size()));
  }
  for (BodyDelassus& body : delassus.bodies) {
    const auto points = Eigen::Index(body.points.size());
    MatrixXd half(6 + 3 * points, 3 * points);
    for (double& value : half.reshaped()) value = random.uniform(-1, 1);
    half.bottomRows(3 * points) *= softness;
    for (Eigen::Index i = 1; i < points; i += 3)
      half.middleCols<3>(3 * i) =
          alikeness * half.middleCols<3>(3 * i - 3) + (1 - alikeness) * half.middleCols<3>(3 * i);
    body.W = half.transpose() * half;
  }
  return delassus;
}

struct Sample {
  Delassus delassus;
  std::vector<ContactRow> rows;
  VectorXd q;
};

Sample random_sample(int seed, int count, double alikeness, double softness = 1, int bodies = 2) {
  Random random(seed);
  const int all = (bodies - 1) * count;
  Sample sample{random_delassus(random, bodies, count, alikeness, softness), {}, VectorXd(3 * all)};
  for (int i = 0; i < all; ++i) {
    const Vector3d normal = Vector3d(random.uniform(-0.3, 0.3), 1, random.uniform(-0.3, 0.3)).normalized();
    sample.rows.push_back({normal, i % 4 == 0 ? 0.0 : 0.5, 0});
    sample.q.segment<3>(3 * i) = Vector3d(random.uniform(-1, 1), random.uniform(-2, 0), random.uniform(-1, 1));
  }
  return sample;
}

// the largest violation of Signorini and Coulomb, each in its own unit
double violation(const Sample& sample, const VectorXd& forces) {
  const VectorXd w = dense(sample.delassus) * forces + sample.q;
  double worst = 0;
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    const ContactRow& row = sample.rows[i];
    const Vector3d f = forces.segment<3>(3 * Eigen::Index(i)), v = w.segment<3>(3 * Eigen::Index(i));
    const double fn = row.normal.dot(f), vn = row.normal.dot(v) + row.bias;
    const Vector3d ft = f - fn * row.normal, vt = v - row.normal.dot(v) * row.normal;
    worst = std::max({worst, -fn, -vn, std::min(fn, vn), ft.norm() - row.friction * fn});
    // friction opposes sliding with all its force, or nothing slides
    const double missing = (row.friction * fn * vt + ft * vt.norm()).norm();
    worst = std::max(worst, missing);
  }
  return worst;
}

}  // namespace

TEST_CASE("contact forces obey Signorini and Coulomb, also where contacts are nearly the same") {
  const double alikeness = GENERATE(0.0, 0.9, 0.999);
  const int seed = GENERATE(1, 2, 3, 4);
  CAPTURE(alikeness, seed);
  const Sample sample = random_sample(seed, 24, alikeness);
  VectorXd forces = VectorXd::Zero(sample.q.size());
  const GaussSeidelResult result =
      solve_contacts(sample.delassus, sample.rows, sample.q, {.max_sweeps = 2000, .tolerance = 1e-10}, forces);
  CHECK(result.converged);
  CHECK(violation(sample, forces) < 1e-6);
}

TEST_CASE("Newton steps settle in tens of sweeps what sweeps alone do not in thousands") {
  const Sample sample = random_sample(7, 24, 0, 0.02);
  const GaussSeidelOptions options{.max_sweeps = 2000, .tolerance = 1e-10};
  VectorXd forces = VectorXd::Zero(sample.q.size()), swept = forces;
  const GaussSeidelResult with_newton = solve_contacts(sample.delassus, sample.rows, sample.q, options, forces);
  const GaussSeidelResult alone = gauss_seidel({dense(sample.delassus), sample.q, sample.rows, 0}, options, swept);
  CAPTURE(with_newton.sweeps, alone.sweeps);
  CHECK(with_newton.converged);
  CHECK(alone.sweeps > 5 * with_newton.sweeps);
  CHECK(violation(sample, forces) < 1e-6);
}

TEST_CASE("Newton steps settle the contacts of many bodies, too") {
  const Sample sample = random_sample(3, 5, 0.9, 0.1, 301);
  VectorXd forces = VectorXd::Zero(sample.q.size());
  const GaussSeidelResult result =
      solve_contacts(sample.delassus, sample.rows, sample.q, {.max_sweeps = 2000, .tolerance = 1e-10}, forces);
  CAPTURE(result.sweeps);
  CHECK(result.converged);
  CHECK(result.sweeps < 90);  // 61; 123 by sweeps and their means alone
  CHECK(violation(sample, forces) < 1e-6);

  const GaussSeidelOptions rough{.max_sweeps = 2000, .tolerance = 1e-10, .is_rough = true};
  VectorXd swept = VectorXd::Zero(sample.q.size());
  const GaussSeidelResult by_sweeps = solve_contacts(sample.delassus, sample.rows, sample.q, rough, swept);
  CAPTURE(by_sweeps.sweeps);
  CHECK(by_sweeps.converged);
  CHECK(by_sweeps.sweeps > result.sweeps);  // no Newton steps
  CHECK(violation(sample, swept) < 1e-6);
}

TEST_CASE("means of sweeps settle many contacts that depend on each other, which sweeps alone hardly move") {
  const Sample sample = random_sample(5, 80, 0, 0.02);
  const GaussSeidelOptions options{.max_sweeps = 2000, .tolerance = 1e-6};
  VectorXd forces = VectorXd::Zero(sample.q.size()), swept = forces;
  const GaussSeidelResult with_means = solve_contacts(sample.delassus, sample.rows, sample.q, options, forces);
  const GaussSeidelResult alone = gauss_seidel({dense(sample.delassus), sample.q, sample.rows, 0}, options, swept);
  CAPTURE(with_means.sweeps, alone.sweeps, violation(sample, forces), violation(sample, swept));
  CHECK(with_means.converged);
  CHECK(with_means.sweeps < 400);
  CHECK(alone.sweeps > 1500);
}

TEST_CASE("contacts that do not push are left out of sweeps, until others push them together") {
  // most are open by so much that they stay so, some by so little that what pushes others closes them
  Sample sample = random_sample(13, 120, 0, 0.3);
  for (std::size_t i = 0; i < sample.rows.size(); ++i) sample.rows[i].bias = i % 3 == 0 ? 0 : i % 3 == 1 ? 2 : 40;
  const GaussSeidelOptions options{.max_sweeps = 2000, .tolerance = 1e-10};
  VectorXd forces = VectorXd::Zero(sample.q.size());
  CHECK(solve_contacts(sample.delassus, sample.rows, sample.q, options, forces).converged);
  CHECK(violation(sample, forces) < 1e-6);

  const ContactProblem all =
      make_contact_problem(sample.delassus, sample.rows, sample.q, {VectorXd::Zero(sample.q.size()), 0});
  std::vector<int> pushing, joining;
  for (int i = 0; i < all.count(); ++i)
    if (!forces.segment<3>(3 * i).isZero(0)) {
      pushing.push_back(i);
      if (sample.rows[i].normal.dot(sample.q.segment<3>(3 * i)) + sample.rows[i].bias > 0) joining.push_back(i);
    }
  CHECK(joining.size() > 3);  // open without forces
  CHECK(pushing.size() < sample.rows.size() / 2);

  // these alone are the same problem
  const ContactPart part(all, pushing);
  const ContactState state{forces, motions_of(all, forces)}, some = part.state_of(state),
                                                             again = part.state_of_all(some);
  CHECK(what_is_left(part.problem(), some) < 1e-9);
  CHECK(again.forces == forces);
  for (std::size_t i = 0; i < pushing.size(); ++i)
    CHECK((motion_of(part.problem(), some, int(i)) - motion_of(all, state, pushing[i])).norm() < 1e-9);
}

TEST_CASE("where sweeps end before forces are settled, none that has to push has been left out") {
  Sample sample = random_sample(17, 120, 0, 0.05);
  for (std::size_t i = 0; i < sample.rows.size(); ++i) sample.rows[i].bias = i % 2 == 0 ? 0 : 2;
  const int sweeps = GENERATE(13, 20);
  VectorXd forces = VectorXd::Zero(sample.q.size());
  const GaussSeidelOptions options{.max_sweeps = sweeps, .tolerance = 1e-14, .is_rough = true};
  CHECK(solve_contacts(sample.delassus, sample.rows, sample.q, options, forces).sweeps == sweeps);
  const VectorXd w = dense(sample.delassus) * forces + sample.q;
  double typical = 0, left_out = 0;  // approach of those without force beside the free ones
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    const auto at = 3 * Eigen::Index(i);
    const ContactRow& row = sample.rows[i];
    typical = std::max(typical, -(row.normal.dot(sample.q.segment<3>(at)) + row.bias));
    if (forces.segment<3>(at).isZero(0)) left_out = std::max(left_out, -(row.normal.dot(w.segment<3>(at)) + row.bias));
  }
  CAPTURE(sweeps, typical, left_out);
  CHECK(left_out < 0.2 * typical);
}

TEST_CASE("forces that are right stay as they are") {
  const Sample sample = random_sample(11, 12, 0);
  VectorXd forces = VectorXd::Zero(sample.q.size());
  solve_contacts(sample.delassus, sample.rows, sample.q, {.tolerance = 1e-12}, forces);
  const VectorXd before = forces;
  CHECK(solve_contacts(sample.delassus, sample.rows, sample.q, {.tolerance = 1e-9}, forces).sweeps == 1);
  CHECK((forces - before).norm() <= 1e-9 * before.norm());
}

TEST_CASE("contacts at one place go on sharing what they bear as they did before, if their forces are held") {
  // two without friction, on one body: either bears all as well as both do
  Sample sample{{}, {{}, {}}, VectorXd(6)};
  BodyDelassus body;
  body.points.resize(2);
  body.W = Matrix3d::Identity().replicate(2, 2);
  sample.delassus.bodies.push_back(body);
  for (const int i : {0, 1}) {
    sample.delassus.sides.push_back({0, i, 1});
    sample.delassus.first_side.push_back(i + 1);
    sample.q.segment<3>(3 * i) = Vector3d(0, -14, 0);
  }
  VectorXd forces = VectorXd::Zero(6);
  forces[1] = 10, forces[4] = 2;
  const GaussSeidelOptions held{.max_sweeps = 2000, .tolerance = 1e-12, .proximal_weight = 1e-3};
  CHECK(solve_contacts(sample.delassus, sample.rows, sample.q, held, forces).converged);
  CHECK(forces[1] - forces[4] == Approx(8).epsilon(1e-6));
  CHECK(forces[1] + forces[4] == Approx(14).epsilon(1e-3));
}

TEST_CASE("held forces become those of free ones, as they are held near the ones that were found before") {
  const bool is_many = GENERATE(false, true);  // one body after the other: Newton's matrix is sparse
  const Sample sample = is_many ? random_sample(3, 5, 0.9, 0.1, 301) : random_sample(2, 24, 0.9);
  const GaussSeidelOptions held{.max_sweeps = 2000, .tolerance = 1e-10, .proximal_weight = 1e-3};
  VectorXd forces = VectorXd::Zero(sample.q.size());
  std::vector<double> left;
  for (int time = 0; time < 4; ++time) {
    CHECK(solve_contacts(sample.delassus, sample.rows, sample.q, held, forces).converged);
    left.push_back(violation(sample, forces));
  }
  CAPTURE(is_many, left);
  CHECK(left[0] > 1e-5);
  CHECK(left[1] < 0.1 * left[0]);
  CHECK(left[3] < 1e-5);
}
