#include "tools/reproduce/printed_equations.h"

#include <Eigen/SVD>
#include <algorithm>

namespace umax::printed {
namespace {

// [PPO13] Eq. 7, 11
Matrix3d displacement_gradient(const HexShape& shape, const Matrix3d& R, const Matrix8x3d& x, int q) {
  return R.transpose() * (x.transpose() * shape.gradients[q]) - Matrix3d::Identity();
}

// alpha_i, beta_i, gamma_i
Vector3d coefficients(const Moduli& moduli, int i) {
  Vector3d row = Vector3d::Constant(moduli.E2);
  row[i] = moduli.E1;
  return row;
}

// [PPO13] Eq. 17 of one point and node j, whose derivatives are h
Vector3d density_derivative(const Moduli& moduli, const Matrix3d& R, const Matrix3d& du, const Vector3d& h,
                            double shear_modulus) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vector3d row = coefficients(moduli, i);
    sum += row.dot(du.diagonal()) * h[i] * R.col(i) + du(i, i) * (R * row.cwiseProduct(h));
  }
  for (int i = 0; i < 3; ++i)
    for (int k = i + 1; k < 3; ++k) sum += shear_modulus * (du(i, k) + du(k, i)) * (h[k] * R.col(i) + h[i] * R.col(k));
  return sum;
}

}  // namespace

Matrix3d equation_6(const Matrix8x3d& X, const Matrix8x3d& x, const Vector3d& s) {
  const Matrix8x3d H = shape_gradients(s);
  Matrix3d G = Matrix3d::Zero();
  for (int n = 0; n < 8; ++n) {
    const Matrix3d term = X.row(n).transpose() * H.row(n);
    const Matrix3d inverse = term.transpose() / term.squaredNorm();  // Moore-Penrose, of a matrix of rank one
    G += x.row(n).transpose() * H.row(n) * inverse;
  }
  return G;
}

double equation_6_reciprocal_condition(const Matrix8x3d& X, const Vector3d& s) {
  const Matrix8x3d H = shape_gradients(s);
  double best = 0;
  for (int n = 0; n < 8; ++n) {
    const Matrix3d term = X.row(n).transpose() * H.row(n);
    const Vector3d values = Eigen::JacobiSVD<Matrix3d>(term).singularValues();
    best = std::max(best, values[2] / values[0]);
  }
  return best;
}

Matrix24d equation_9(const HexShape& shape, Derivatives derivatives) {
  const Matrix3d E = elasticity_matrix(1, shape.poisson).topLeftCorner<3, 3>();
  Matrix24d K = Matrix24d::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix8x3d h =
        derivatives == Derivatives::natural ? shape_gradients(quadrature_points()[q]) : shape.gradients[q];
    Eigen::Matrix<double, 3, 24> B;
    for (int n = 0; n < 8; ++n) B.middleCols<3>(3 * n) = Vector3d(h.row(n)).asDiagonal();
    K += shape.weights[q] * (B.transpose() * (E * B));
  }
  return K;
}

Matrix24d equation_9_with_shear(const HexShape& shape) {
  // H is H F^-1 of the cube [-1, 1]^3, whose volume is 8
  Matrix8x3d cube;
  for (int n = 0; n < 8; ++n) cube.row(n) << (n & 4 ? 1 : -1), (n & 2 ? 1 : -1), (n & 1 ? 1 : -1);
  return shape.volume / 8 * make_hex_shape(cube, shape.poisson).stiffness;
}

double equation_16(const Moduli& moduli, const Matrix3d& du) {
  double density = 0;
  for (int i = 0; i < 3; ++i) density += du(i, i) * coefficients(moduli, i).dot(du.diagonal());
  for (int i = 0; i < 3; ++i)
    for (int k = i + 1; k < 3; ++k) density += 0.5 * moduli.E3 * (du(i, k) + du(k, i)) * (du(i, k) + du(k, i));
  return density;
}

double equation_13(const HexShape& shape, const Moduli& moduli, const Matrix3d& R, const Matrix8x3d& x) {
  double energy = 0;
  for (int q = 0; q < 8; ++q) energy += shape.weights[q] * equation_16(moduli, displacement_gradient(shape, R, x, q));
  return energy;
}

Vector24d equation_17(const HexShape& shape, const Moduli& moduli, const Matrix3d& R, const Matrix8x3d& x,
                      ShearModulus shear, Derivatives derivatives) {
  const double shear_modulus = shear == ShearModulus::E2 ? moduli.E2 : moduli.E3;
  Vector24d sum = Vector24d::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix3d du = displacement_gradient(shape, R, x, q);
    const Matrix8x3d h =
        derivatives == Derivatives::natural ? shape_gradients(quadrature_points()[q]) : shape.gradients[q];
    for (int j = 0; j < 8; ++j)
      sum.segment<3>(3 * j) += shape.weights[q] * density_derivative(moduli, R, du, h.row(j), shear_modulus);
  }
  return sum;
}

Vector24d equation_15(const Vector24d& sum, double limit) {
  return -sum / limit;
}

}  // namespace umax::printed
