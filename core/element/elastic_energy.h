// Co-rotational linear elasticity of one hexahedron: U, its gradient and its Hessian.
//
// [PPO13] Eq. 9-13   U_e  = Y/2 u^T K u,   u_j = R^T x_j - X_j,   R = polar(G),   G = sum_j x_j h_j^T
//
// Exact gradient (R moves with x), about the centroid:
//   y_j      = R^T x_j,   g = Y K u,   S = R^T G,   D = tr(S) I - S
//   p        = D^-1 sum_j y_j x g_j
//   dU/dx_j  = R (g_j - p x h_j)
// Exact Hessian: elastic_energy.cpp.
//
// x_j, X_j: node j now and at rest [m];  u: displacement in the element's frame [m];  R: rotation, S: stretch [-]
// h_j: gradient of the node's shape function at rest [1/m];  Y: Young's modulus [Pa];  K: stiffness for Y = 1 [m]
// Deviation: the paper discards dR/dx; that leaves a spurious torque. The warped force R K u is kept for comparison.
#pragma once

#include "core/base/types.h"
#include "core/element/hexahedron.h"

namespace umax {

/// An element's nodes seen from its own rotated frame; filled by corotate(), read by all functions below.
struct CorotatedHex {
  Matrix3d rotation = Matrix3d::Identity();     // R, world from local
  Matrix3d stretch = Matrix3d::Identity();      // S = R^T G of the rotation estimate
  Matrix8x3d local_nodes = Matrix8x3d::Zero();  // [m] y_j, relative to the centroid
  Vector24d displacement = Vector24d::Zero();   // [m] u = y - X
};

/// x: 8 x 3 current positions [m].
CorotatedHex corotate(const HexShape& shape, RotationEstimate estimate, const Matrix8x3d& x);

/// U [J] for stiffness matrix K (HexShape::stiffness or ::stiffness_paper) and Young's modulus [Pa].
double elastic_energy(const Matrix24d& K, double young, const CorotatedHex& hex);

/// R Y K u [N]: minus the warped elastic force. With K = stiffness_paper: the paper's R-fixed gradient of its energy.
Vector24d warped_gradient(const Matrix24d& K, double young, const CorotatedHex& hex);

/// dU/dx [N], exact. h: HexShape::rotation_gradients of the estimate used in corotate(). Where the rotation is (nearly)
/// undetermined (D singular: an inverted or collapsed element) the torque term of that direction fades out
/// continuously.
Vector24d exact_gradient(const Matrix24d& K, double young, const Matrix8x3d& h, const CorotatedHex& hex);

/// U and dU/dx at once.
struct EnergyWithGradient {
  double energy = 0;
  Vector24d gradient;
};
EnergyWithGradient energy_with_gradient(const Matrix24d& K, double young, const Matrix8x3d& h, const CorotatedHex& hex);

/// R Y K R^T [N/m]: positive semi-definite.
Matrix24d warped_hessian(const Matrix24d& K, double young, const CorotatedHex& hex);

/// R Y K R^T x, for 8 x 3 motions of the nodes.
Vector24d warped_product(const Matrix24d& K, double young, const Matrix3d& rotation, const Matrix8x3d& x);

/// d2U/dx2 [N/m], exact and symmetric; may be indefinite.
Matrix24d exact_hessian(const Matrix24d& K, double young, const Matrix8x3d& h, const CorotatedHex& hex);

}  // namespace umax
