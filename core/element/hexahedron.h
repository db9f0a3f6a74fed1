// Trilinear hexahedron: shape functions, 2x2x2 Gauss quadrature and what follows from the rest shape alone.
//
// [PPO13] Eq. 5   N_n(s) = 1/8 (1 + s_n1 s_1)(1 + s_n2 s_2)(1 + s_n3 s_3),   s in [-1, 1]^3
// [PPO13] Eq. 8   s_q    = (+-1, +-1, +-1) / sqrt(3),   w_q = 1
//
// N_n: shape function of node n [-];  s: local coordinates [-];  s_q, w_q: the 8 quadrature points and weights
// Local node order [PPO13] Fig. 2: node n has s_n = (bit 2, bit 1, bit 0 of n), 0 -> -1, 1 -> +1; so z is fastest.
// Correction: Eq. 9 needs B (6 x 24) made of MATERIAL derivatives dN/dX = H F^-1, not of H.
#pragma once

#include <array>
#include <string>

#include "core/base/types.h"

namespace umax {

/// N_n at local coordinates s in [-1, 1]^3.
Vector8d shape_functions(const Vector3d& s);

/// Row n is dN_n/ds at local coordinates s.
Matrix8x3d shape_gradients(const Vector3d& s);

/// The 8 quadrature points, in the nodes' order.
const std::array<Vector3d, 8>& quadrature_points();

/// Which linear map the element's rotation is taken from (docs/solvers.md, Rotation estimate).
enum class RotationEstimate {
  centre,       // deformation gradient at the element's centre (default: symmetric)
  tetrahedron,  // inner tetrahedron of the 5-tetrahedra cut
  kuhn,         // one tetrahedron of the Coxeter-Freudenthal-Kuhn cut, as the paper
};
inline constexpr int num_rotation_estimates = 3;

/// Everything an element's energy needs from its rest shape and Poisson's ratio; equal hexes share one.
/// Stiffness is for unit Young's modulus: multiply by Young's modulus [Pa].
struct HexShape {
  Matrix8x3d rest_nodes = Matrix8x3d::Zero();     // [m] relative to the centroid of the 8 nodes
  double volume = 0;                              // [m^3]
  double poisson = 0;                             // [-]
  Matrix24d stiffness = Matrix24d::Zero();        // [m] true energy U = Y/2 u^T K u
  Matrix24d stiffness_paper = Matrix24d::Zero();  // [m] the paper's energy (Eq. 16) as 1/2 u^T K_p u
  std::array<Matrix8x3d, num_rotation_estimates> rotation_gradients{};  // [1/m] row j: h_j with G_c = sum_j x_j h_j^T
  std::array<Matrix8x3d, 8> gradients{};                                // [1/m] row j: dN_j/dX at each quadrature point
  std::array<double, 8> weights{};                                      // [m^3] w_q det(dX/ds)
};

/// nodes: 8 x 3 rest positions [m]. The general isoparametric map; throws Error (bad_data) if det(dX/ds) <= 0
/// at a node or quadrature point.
HexShape make_hex_shape(const Matrix8x3d& nodes, double poisson);

/// [m^3] integral of each node's shape function over the hex: its share of the volume. They sum to the volume, and
/// masses in this ratio have the centre of mass of the hex (row-sum lumping).
Vector8d node_volumes(const HexShape& shape);

/// B^T E B at quadrature point 0 ... 7, and its integral over the hex. E: 6 x 6, as elasticity_matrix().
Matrix24d point_stiffness(const HexShape& shape, const Matrix6d& E, int point);
Matrix24d integrate_stiffness(const HexShape& shape, const Matrix6d& E);

/// How far a hex is from a box, by det(dX/ds) at its nodes and quadrature points.
struct HexQuality {
  double least_determinant = 0;  // [m^3]
  int place = 0;                 // of the least: quadrature point 0 ... 7, or 8 + node
  double determinant_ratio = 0;  // [-] least over largest: 1 for a parallelepiped
  double scaled_jacobian = 0;    // [-] least triple product of the unit edges at a node: 1 for a box, <= 0: inverted
  bool usable = false;           // make_hex_shape() takes it
};
HexQuality hex_quality(const Matrix8x3d& nodes);

/// "node 3" or "quadrature point 5", from HexQuality::place.
std::string place_name(int place);

}  // namespace umax
