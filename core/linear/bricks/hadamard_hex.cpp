#include "core/linear/bricks/hadamard_hex.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <iterator>

namespace umax {
namespace {

// mode m alternates along the axes of its bits, as node n stands on the upper side along the axes of its bits
double sign(int mode, int node) {
  const int lower = mode & ~node;
  return ((lower >> 2) + (lower >> 1) + lower) & 1 ? -1 : 1;
}

// stiffness in modes: u_n = 1/8 sum_m (+-1) u^_m
Matrix24d in_modes(const Matrix24d& K) {
  Matrix24d W = Matrix24d::Zero();
  for (int mode = 0; mode < 8; ++mode)
    for (int node = 0; node < 8; ++node)
      W.block<3, 3>(3 * mode, 3 * node) = sign(mode, node) / 8 * Matrix3d::Identity();
  return W * K * W.transpose();
}

constexpr int x = 4, y = 2, z = 1, xy = 6, xz = 5, yz = 3, xyz = 7;  // modes

// moves the couplings between the given (mode, component) out of K, upper triangle row by row
template <int count>
void take(const int (&at)[count], Matrix24d& K, double* to) {
  for (int row = 0; row < count; ++row)
    for (int column = row; column < count; ++column) {
      *to++ = K(at[row], at[column]);
      K(at[row], at[column]) = K(at[column], at[row]) = 0;
    }
}

}  // namespace

HexConstants<double> make_hex_constants(const HexShape& box) {
  Matrix24d K = in_modes(box.stiffness);
  [[maybe_unused]] const double size = K.cwiseAbs().maxCoeff();
  HexConstants<double> k;
  const auto at = [](int mode, int component) { return 3 * mode + component; };
  take({at(x, 0), at(y, 1), at(z, 2)}, K, k.normal);
  take({at(x, 1), at(y, 0)}, K, k.shear[0]);
  take({at(x, 2), at(z, 0)}, K, k.shear[1]);
  take({at(y, 2), at(z, 1)}, K, k.shear[2]);
  take({at(xy, 1), at(xz, 2)}, K, k.bend[0]);
  take({at(xy, 0), at(yz, 2)}, K, k.bend[1]);
  take({at(xz, 0), at(yz, 1)}, K, k.bend[2]);
  take({at(yz, 0), at(xz, 1), at(xy, 2)}, K, k.twist);
  for (int c = 0; c < 3; ++c) take({at(xyz, c)}, K, k.trilinear + c);
  assert(K.cwiseAbs().maxCoeff() <= 1e-12 * size);  // nothing else couples in a box

  const Matrix3d corner = box.stiffness.bottomRightCorner<3, 3>();
  int next = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column) k.corner[next++] = corner(row, column);
  return k;
}

HexConstants<float> to_float(const HexConstants<double>& constants) {
  HexConstants<float> k;
  const auto convert = [](const auto& from, auto& to) {
    std::transform(std::begin(from), std::end(from), std::begin(to), [](double value) { return float(value); });
  };
  convert(constants.normal, k.normal);
  convert(constants.twist, k.twist);
  convert(constants.trilinear, k.trilinear);
  convert(constants.corner, k.corner);
  for (int pair = 0; pair < 3; ++pair) {
    convert(constants.shear[pair], k.shear[pair]);
    convert(constants.bend[pair], k.bend[pair]);
  }
  return k;
}

double largest_jacobi_eigenvalue(const HexShape& box) {
  Matrix24d K = box.stiffness, scale = Matrix24d::Zero();
  for (int n = 0; n < 8; ++n) {
    const Matrix3d L = Eigen::LLT<Matrix3d>(K.block<3, 3>(3 * n, 3 * n)).matrixL();
    scale.block<3, 3>(3 * n, 3 * n) = L.triangularView<Eigen::Lower>().solve(Matrix3d::Identity());
  }
  const Matrix24d scaled = scale * K * scale.transpose();
  return Eigen::SelfAdjointEigenSolver<Matrix24d>(scaled, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

HexShape make_box_shape(const Vector3d& cell_size, double poisson) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n)
    for (int axis = 0; axis < 3; ++axis) nodes(n, axis) = (n >> (2 - axis) & 1) * cell_size[axis];
  return make_hex_shape(nodes, poisson);
}

}  // namespace umax
