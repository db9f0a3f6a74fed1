#include "core/element/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace umax {
namespace {

Matrix3d cofactors(const Matrix3d& X) {
  Matrix3d C;
  C.col(0) = X.col(1).cross(X.col(2));
  C.col(1) = X.col(2).cross(X.col(0));
  C.col(2) = X.col(0).cross(X.col(1));
  return C;
}

// Any input: flips the direction of the smallest singular value when that is what makes the rotation proper.
Matrix3d polar_by_svd(const Matrix3d& G) {
  const Eigen::JacobiSVD<Matrix3d> svd(G, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  if (U.determinant() * svd.matrixV().determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

// Newton's iteration, for well-conditioned X with det X > 0:
//   X <- (a X + X^-T / a) / 2,   a = sqrt(|X^-1| / |X|) as long as X is far from orthogonal, then 1
// cofactors_of_X = det(X) X^-T of the first iterate.
Matrix3d polar_by_newton(Matrix3d X, Matrix3d cofactors_of_X, double det) {
  constexpr double far = 0.1, converged = 1e-17;  // squared change; the error left is half of it
  constexpr int max_iterations = 16;              // 9 suffice for condition numbers that come here
  double change = 1;
  for (int k = 0; k < max_iterations && change > converged; ++k) {
    double a = 1;
    if (change > far) a = std::sqrt(cofactors_of_X.norm() / (det * X.norm()));
    const Matrix3d next = (0.5 * a) * X + (0.5 / (a * det)) * cofactors_of_X;
    change = (next - X).squaredNorm();
    X = next;
    cofactors_of_X = cofactors(X);
    det = X.col(0).dot(cofactors_of_X.col(0));
  }
  return X;
}

// Sine and cosine that are exact at multiples of 90 degrees.
std::pair<double, double> sine_cosine(double degrees) {
  int quarter = 0;
  const double rest = std::remquo(degrees, 90.0, &quarter) * (std::numbers::pi / 180);
  const double s = std::sin(rest), c = std::cos(rest);
  switch (quarter & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace

Matrix3d polar_rotation(const Matrix3d& G) {
  assert(G.allFinite());
  const double largest = G.cwiseAbs().maxCoeff();
  if (!(largest > 0)) return Matrix3d::Identity();
  const Matrix3d X = G / largest;
  const Matrix3d C = cofactors(X);
  const double det = X.col(0).dot(C.col(0));
  constexpr double well_conditioned = 1e-3;  // largest entry is 1, so this bounds the condition number by about 2e4
  return det > well_conditioned ? polar_by_newton(X, C, det) : polar_by_svd(X);
}

Matrix3d rotation_from_degrees(const Vector3d& degrees_xyz) {
  const auto [sx, cx] = sine_cosine(degrees_xyz.x());
  const auto [sy, cy] = sine_cosine(degrees_xyz.y());
  const auto [sz, cz] = sine_cosine(degrees_xyz.z());
  Matrix3d X, Y, Z;
  X << 1, 0, 0, 0, cx, -sx, 0, sx, cx;
  Y << cy, 0, sy, 0, 1, 0, -sy, 0, cy;
  Z << cz, -sz, 0, sz, cz, 0, 0, 0, 1;
  return Z * Y * X;
}

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace umax
