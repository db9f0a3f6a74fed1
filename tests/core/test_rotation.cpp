#include "core/element/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

double distance_from_proper(const Matrix3d& R) {
  return std::max((R.transpose() * R - Matrix3d::Identity()).norm(), std::abs(R.determinant() - 1));
}

// No rotation in a fine neighbourhood or among random ones has a larger tr(R^T G).
bool maximises_trace(const Matrix3d& R, const Matrix3d& G, Random& random) {
  const double best = (R.transpose() * G).trace(), slack = 1e-13 * G.norm();
  for (int i = 0; i < 50; ++i) {
    const Matrix3d far = random.rotation();
    const Matrix3d near = R * Eigen::AngleAxisd(1e-3, random.vector(1).normalized()).toRotationMatrix();
    if ((far.transpose() * G).trace() > best + slack || (near.transpose() * G).trace() > best + slack) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("the polar rotation of rotation times stretch is the rotation") {
  Random random(1);
  double worst = 0, worst_orthogonality = 0;
  for (int i = 0; i < 1000; ++i) {
    const Matrix3d R = random.rotation(), axes = random.rotation();
    const Vector3d stretch(random.uniform(0.3, 3), random.uniform(0.3, 3), random.uniform(0.3, 3));
    const Matrix3d found = polar_rotation(R * axes * stretch.asDiagonal() * axes.transpose());
    worst = std::max(worst, (found - R).cwiseAbs().maxCoeff());
    worst_orthogonality = std::max(worst_orthogonality, distance_from_proper(found));
  }
  CHECK(worst < 5e-15);
  CHECK(worst_orthogonality < 3e-15);
}

TEST_CASE("the polar rotation is the same on both sides of every switch of method") {
  // the smallest singular value runs through all magnitudes, zero and negative ones included
  Random random(2);
  for (const double smallest : {0.1, 1e-2, 1.01e-3, 1e-3, 0.99e-3, 1e-4, 1e-6, 1e-12, 0.0, -1e-12, -1e-3, -0.1, -0.5}) {
    const Matrix3d R = random.rotation(), axes = random.rotation();
    const Matrix3d G = R * axes * Vector3d(1.3, 0.9, smallest).asDiagonal() * axes.transpose();
    const Matrix3d found = polar_rotation(G);
    INFO("smallest singular value " << smallest);
    CHECK((found - R).cwiseAbs().maxCoeff() < 1e-14);
    CHECK(distance_from_proper(found) < 3e-15);
  }
}

TEST_CASE("the polar rotation maximises the trace, for inverted input too") {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d G = random.matrix(1);  // half of them inverted
    const Matrix3d R = polar_rotation(G);
    CHECK(distance_from_proper(R) < 4e-15);
    CHECK(maximises_trace(R, G, random));
    const Matrix3d S = R.transpose() * G;
    CHECK((S - S.transpose()).norm() < 1e-14);
  }
}

TEST_CASE("degenerate input has a proper rotation that maximises the trace") {
  const Vector3d a(1, -2, 0.5), b(0.3, 0.1, -2), c(1, 1, 1), d(-2, 0, 1);
  std::vector<Matrix3d> inputs = {Matrix3d::Zero(),
                                  Matrix3d::Constant(1),
                                  -Matrix3d::Identity(),
                                  a * b.transpose(),
                                  a * b.transpose() + c * d.transpose(),
                                  Matrix3d(Vector3d(1, 1, -1).asDiagonal()),
                                  Matrix3d(Vector3d(-1, -1, 1).asDiagonal()),
                                  Matrix3d(Vector3d(0, 0, -3).asDiagonal())};
  inputs.push_back(Matrix3d::Constant(-0.0));
  Random random(4);
  for (const double scale : {1.0, 1e-300, 1e-320, 1e300})
    for (const Matrix3d& input : inputs) {
      const Matrix3d G = scale * input;
      const Matrix3d R = polar_rotation(G);
      INFO(G);
      CHECK(distance_from_proper(R) < 4e-15);
      CHECK(R == polar_rotation(G));
      if (scale == 1) CHECK(maximises_trace(R, G, random));
    }
  CHECK(polar_rotation(Matrix3d::Zero()) == Matrix3d::Identity());
}

TEST_CASE("the polar rotation does not depend on the size of its input") {
  Random random(6);
  for (int i = 0; i < 20; ++i) {
    const Matrix3d G = random.matrix(1);
    CHECK(polar_rotation(G) == polar_rotation(Matrix3d(0x1p40 * G)));  // powers of two: the same bits
    CHECK((polar_rotation(G) - polar_rotation(Matrix3d(1e-9 * G))).norm() < 1e-12);
  }
}

TEST_CASE("angles turn about world X, then Y, then Z, exactly at quarter turns") {
  Matrix3d expected;
  expected << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  CHECK(rotation_from_degrees({90, 0, 0}) == expected);
  CHECK(rotation_from_degrees({90, 90, 0}) * Vector3d::UnitY() == Vector3d::UnitX());  // y -> z -> x
  CHECK(rotation_from_degrees({0, 0, -270}) * Vector3d::UnitX() == Vector3d::UnitY());
  CHECK(rotation_from_degrees({0, 180, 0}) * Vector3d::UnitX() == -Vector3d::UnitX());
  CHECK(rotation_from_degrees({720, 360, -360}) == Matrix3d::Identity());
  const double radian = 3.14159265358979323846 / 180;
  const Matrix3d composed =
      (Eigen::AngleAxisd(70 * radian, Vector3d::UnitZ()) * Eigen::AngleAxisd(-200 * radian, Vector3d::UnitY()) *
       Eigen::AngleAxisd(33 * radian, Vector3d::UnitX()))
          .toRotationMatrix();
  CHECK((rotation_from_degrees({33, -200, 70}) - composed).norm() < 1e-15);
}

TEST_CASE("a cross matrix times a vector is the cross product") {
  const Vector3d v(1, -2, 3), w(0.5, 4, -1);
  CHECK(cross_matrix(v) * w == v.cross(w));
}
