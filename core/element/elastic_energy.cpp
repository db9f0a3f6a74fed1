// The exact Hessian as a rank-6 change of the warped stiffness, with the symbols of elastic_energy.h.
//
// In the local frame, z_j = R^T dx_j and q_j = g_j - p x h_j, with the stacks (24 x 3)
//   Y_j          = [y_j]x
//   (W^T)_j      = [h_j]x^T D^-1                       so that w = W z is the local spin of R
// the derivatives are
//   du           = P z,   P = I + Y W
//   dp           = D^-1 (sum_k (P z)_k x g_k - dD p) + (the part that is inside P^T K P)
// and collecting terms in
//   H z          = P^T K P z + (w x q_j)_j - (dp x h_j)_j
// leaves
//   H            = K + L W + W^T L^T + W^T C W
//   L_j          = (K Y)_j - [g_j]x + h_j p^T - (h_j . p) I
//   C            = sym(Y^T K Y - (sum_k y_k . g_k) I + sum_k y_k g_k^T + [p]x S)
// In the world's frame
//   R H R^T      = R K R^T + (R L)(R W^T)^T + ...      all blocks R applied node by node
//
// [a]x: matrix of the cross product with a;  here Y is the stack above, and K has Young's modulus in it
#include "core/element/elastic_energy.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "core/element/rotation.h"

namespace umax {
namespace {

using Matrix24x3d = Eigen::Matrix<double, 24, 3>;
using Matrix24x4d = Eigen::Matrix<double, 24, 4>;
using Nodes = Eigen::Map<const Matrix8x3d>;

// D's eigenvalues are s_i + s_j of the singular values, 2 at rest.
constexpr double smallest_trusted_D = 1e-2;

// D^-1 for D = tr(S) I - S. Below the trusted size d an eigenvalue e counts as e / d^2 in place of 1 / e: continuous,
// and zero where an inverted or flat element leaves the rotation undetermined.
Matrix3d regularised_inverse(const Matrix3d& S) {
  const Matrix3d D = S.trace() * Matrix3d::Identity() - S;
  const double trace = D.trace();
  const double determinant = D.determinant();
  // the smallest eigenvalue is at least det / (tr / 2)^2
  if (4 * determinant > smallest_trusted_D * trace * trace) return D.inverse();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(D);
  Vector3d inverse;
  for (int i = 0; i < 3; ++i) {
    const double e = eigen.eigenvalues()[i];
    inverse[i] = e >= smallest_trusted_D ? 1 / e : std::max(e, 0.0) / (smallest_trusted_D * smallest_trusted_D);
  }
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

// Twice the axial vector of A's antisymmetric part: sum_j y_j x g_j for A = sum_j y_j g_j^T.
Vector3d axial(const Matrix3d& A) {
  return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)};
}

// K B. The lazy product keeps the accumulators in registers at these sizes.
template <int N>
Eigen::Matrix<double, 24, N> multiply(const Matrix24d& K, const Eigen::Matrix<double, 24, N>& B) {
  return K.lazyProduct(B);
}

// R applied to every node of a 24-vector.
Vector24d rotate_nodes(const Matrix3d& R, const Vector24d& local) {
  Vector24d world;
  for (int j = 0; j < 8; ++j) world.segment<3>(3 * j) = R * local.segment<3>(3 * j);
  return world;
}

// A blockdiag(R)^T: whole columns are mixed.
Matrix24d mix_columns(const Matrix24d& A, const Matrix3d& R) {
  Matrix24d mixed;
  for (int j = 0; j < 24; j += 3)
    for (int a = 0; a < 3; ++a) mixed.col(j + a) = R(a, 0) * A.col(j) + R(a, 1) * A.col(j + 1) + R(a, 2) * A.col(j + 2);
  return mixed;
}

}  // namespace

CorotatedHex corotate(const HexShape& shape, RotationEstimate estimate, const Matrix8x3d& x) {
  CorotatedHex hex;
  const Matrix8x3d centred = x.rowwise() - x.colwise().mean();
  const Matrix3d G = centred.transpose().lazyProduct(shape.rotation_gradients[int(estimate)]);
  hex.rotation = polar_rotation(G);
  const Matrix3d S = hex.rotation.transpose() * G;
  hex.stretch = 0.5 * (S + S.transpose());
  hex.local_nodes = centred.lazyProduct(hex.rotation);
  const Matrix8x3d u = hex.local_nodes - shape.rest_nodes;
  hex.displacement = Eigen::Map<const Vector24d>(u.data());
  return hex;
}

double elastic_energy(const Matrix24d& K, double young, const CorotatedHex& hex) {
  return 0.5 * young * hex.displacement.dot(multiply<1>(K, hex.displacement));
}

Vector24d warped_gradient(const Matrix24d& K, double young, const CorotatedHex& hex) {
  return rotate_nodes(young * hex.rotation, multiply<1>(K, hex.displacement));
}

Vector24d exact_gradient(const Matrix24d& K, double young, const Matrix8x3d& h, const CorotatedHex& hex) {
  return energy_with_gradient(K, young, h, hex).gradient;
}

EnergyWithGradient energy_with_gradient(const Matrix24d& K, double young, const Matrix8x3d& h,
                                        const CorotatedHex& hex) {
  Vector24d g = multiply<1>(K, hex.displacement);
  const double energy = 0.5 * young * hex.displacement.dot(g);
  const Matrix3d moments = hex.local_nodes.transpose().lazyProduct(Nodes(g.data()));
  const Vector3d p = regularised_inverse(hex.stretch) * axial(moments);
  for (int j = 0; j < 8; ++j) g.segment<3>(3 * j) -= p.cross(Vector3d(h.row(j)));
  return {energy, rotate_nodes(young * hex.rotation, g)};
}

Matrix24d warped_hessian(const Matrix24d& K, double young, const CorotatedHex& hex) {
  return mix_columns(mix_columns(K, young * hex.rotation).transpose(), hex.rotation);
}

Vector24d warped_product(const Matrix24d& K, double young, const Matrix3d& rotation, const Matrix8x3d& x) {
  const Matrix8x3d local = x.lazyProduct(rotation);
  return rotate_nodes(young * rotation, multiply<1>(K, Eigen::Map<const Vector24d>(local.data())));
}

Matrix24d exact_hessian(const Matrix24d& K, double young, const Matrix8x3d& h, const CorotatedHex& hex) {
  // K times the stack of [y_j]x, and the local force
  Matrix24x4d stack;
  for (int j = 0; j < 8; ++j) stack.block<3, 3>(3 * j, 0) = cross_matrix(hex.local_nodes.row(j));
  stack.col(3) = hex.displacement;
  const Matrix24x4d product = multiply<4>(K, stack);
  const auto Y = stack.leftCols<3>();
  const auto KY = product.leftCols<3>();
  const Nodes g(product.col(3).data());

  // torque, p and the 3 x 3 middle matrix
  const Matrix3d Dinv = regularised_inverse(hex.stretch);
  const Matrix3d moments = hex.local_nodes.transpose().lazyProduct(g);
  const Vector3d p = Dinv * axial(moments);
  Matrix3d C = Y.transpose().lazyProduct(KY);
  C += moments + cross_matrix(p) * hex.stretch;
  C.diagonal().array() -= moments.trace();
  C = (0.5 * (C + C.transpose())).eval();

  // the two factors of the rank-6 change; half of W^T C W goes to each
  Matrix24x3d Wt, L;
  for (int j = 0; j < 8; ++j) {
    const Vector3d hj = h.row(j);
    const Matrix3d Wj = cross_matrix(hj).transpose() * Dinv;
    Matrix3d Lj = KY.middleRows<3>(3 * j) - cross_matrix(g.row(j)) + hj * p.transpose() + 0.5 * Wj * C;
    Lj.diagonal().array() -= hj.dot(p);
    Wt.middleRows<3>(3 * j) = hex.rotation * Wj;
    L.middleRows<3>(3 * j) = (young * hex.rotation) * Lj;
  }
  Matrix24d H = warped_hessian(K, young, hex);
  for (int c = 0; c < 24; ++c)
    for (int k = 0; k < 3; ++k) H.col(c) += Wt(c, k) * L.col(k) + L(c, k) * Wt.col(k);
  return H;
}

}  // namespace umax
