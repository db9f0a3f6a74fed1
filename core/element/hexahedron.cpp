#include "core/element/hexahedron.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "core/base/error.h"
#include "core/element/material.h"

namespace umax {
namespace {

using Matrix6x24d = Eigen::Matrix<double, 6, 24>;

// inner tetrahedron of the 5-tetrahedra cut; a Kuhn tetrahedron (the edges x, y, z along the main diagonal)
constexpr std::array<int, 4> inner_tetrahedron = {0, 3, 5, 6};
constexpr std::array<int, 4> kuhn_tetrahedron = {0, 4, 6, 7};

Vector3d node_sign(int n) {
  return Vector3d(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1);
}

[[noreturn]] void refuse(const std::string& what, double value, const std::string& remedy) {
  std::ostringstream text;
  text << value;
  throw Error(Fault::bad_data, {"hex", what, text.str(), remedy});
}

// [PPO13] F = dX/ds, column k is dX/ds_k.
Matrix3d material_jacobian(const Matrix8x3d& nodes, const Vector3d& s) {
  return nodes.transpose() * shape_gradients(s);
}

void check_not_inverted(const Matrix8x3d& nodes) {
  const HexQuality quality = hex_quality(nodes);
  if (!quality.usable)
    refuse("is inverted or degenerate: det(dX/ds) must be positive at its " + place_name(quality.place),
           quality.least_determinant, "list its nodes with z fastest, then y, then x, and untangle the mesh");
}

// triple product of the unit edges that leave a node
double scaled_jacobian(const Matrix8x3d& nodes, int n) {
  Matrix3d edges;
  for (int axis = 0; axis < 3; ++axis) {
    const int other = n ^ (4 >> axis);
    edges.col(axis) = node_sign(other)[axis] * (nodes.row(other) - nodes.row(n)).normalized();
  }
  return edges.determinant();
}

// strains (xx, yy, zz, yz, xz, xy; engineering shear) of the nodal displacements, from dN/dX
Matrix6x24d strain_matrix(const Matrix8x3d& h) {
  Matrix6x24d B = Matrix6x24d::Zero();
  for (int j = 0; j < 8; ++j) {
    const double x = h(j, 0), y = h(j, 1), z = h(j, 2);
    B.block<6, 3>(0, 3 * j) << x, 0, 0, 0, y, 0, 0, 0, z, 0, z, y, z, 0, x, y, x, 0;
  }
  return B;
}

// h_j of the linear tetrahedron over four of the nodes: zero for the other four
Matrix8x3d tetrahedron_gradients(const Matrix8x3d& nodes, const std::array<int, 4>& corners, const std::string& name) {
  Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = (nodes.row(corners[k + 1]) - nodes.row(corners[0])).transpose();
  const double det = edges.determinant();
  const double size = edges.cwiseAbs().maxCoeff();
  if (!(std::abs(det) > 1e-12 * size * size * size))
    refuse("has a flat " + name + " tetrahedron: no rotation can be taken from it", det / 6, "untangle the mesh");
  const Matrix3d inverse = edges.inverse();
  Matrix8x3d h = Matrix8x3d::Zero();
  for (int k = 0; k < 3; ++k) h.row(corners[k + 1]) = inverse.row(k);
  h.row(corners[0]) = -inverse.colwise().sum();
  return h;
}

}  // namespace

Vector8d shape_functions(const Vector3d& s) {
  Vector8d N;
  for (int n = 0; n < 8; ++n) N[n] = 0.125 * (Vector3d::Ones() + node_sign(n).cwiseProduct(s)).prod();
  return N;
}

Matrix8x3d shape_gradients(const Vector3d& s) {
  Matrix8x3d H;
  for (int n = 0; n < 8; ++n) {
    const Vector3d sign = node_sign(n);
    const Vector3d f = Vector3d::Ones() + sign.cwiseProduct(s);
    H.row(n) << 0.125 * sign[0] * f[1] * f[2], 0.125 * sign[1] * f[0] * f[2], 0.125 * sign[2] * f[0] * f[1];
  }
  return H;
}

const std::array<Vector3d, 8>& quadrature_points() {
  static const std::array<Vector3d, 8> points = [] {
    std::array<Vector3d, 8> p;
    for (int n = 0; n < 8; ++n) p[n] = node_sign(n) / std::sqrt(3.0);
    return p;
  }();
  return points;
}

Vector8d node_volumes(const HexShape& shape) {
  Vector8d volumes = Vector8d::Zero();
  for (int q = 0; q < 8; ++q) volumes += shape.weights[q] * shape_functions(quadrature_points()[q]);
  return volumes;
}

Matrix24d point_stiffness(const HexShape& shape, const Matrix6d& E, int point) {
  const Matrix6x24d B = strain_matrix(shape.gradients[point]);
  const Matrix24d K = B.transpose() * (E * B);
  return 0.5 * (K + K.transpose());
}

Matrix24d integrate_stiffness(const HexShape& shape, const Matrix6d& E) {
  Matrix24d K = Matrix24d::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix6x24d B = strain_matrix(shape.gradients[q]);
    K += shape.weights[q] * (B.transpose() * (E * B));
  }
  return 0.5 * (K + K.transpose());
}

HexQuality hex_quality(const Matrix8x3d& nodes) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double size = (nodes.colwise().maxCoeff() - nodes.colwise().minCoeff()).maxCoeff();
  HexQuality quality{.least_determinant = infinity, .scaled_jacobian = infinity};
  double largest = -infinity;
  for (int place = 0; place < 16; ++place) {
    const Vector3d s = place < 8 ? quadrature_points()[place] : node_sign(place - 8);
    const double det = material_jacobian(nodes, s).determinant();
    largest = std::max(largest, det);
    if (det >= quality.least_determinant) continue;
    quality.least_determinant = det;
    quality.place = place;
  }
  for (int n = 0; n < 8; ++n) quality.scaled_jacobian = std::min(quality.scaled_jacobian, scaled_jacobian(nodes, n));
  quality.determinant_ratio = quality.least_determinant / largest;
  quality.usable = nodes.allFinite() && quality.least_determinant > 1e-12 * size * size * size;
  return quality;
}

std::string place_name(int place) {
  return place < 8 ? "quadrature point " + std::to_string(place) : "node " + std::to_string(place - 8);
}

HexShape make_hex_shape(const Matrix8x3d& nodes, double poisson) {
  if (!(poisson > -1 && poisson < 0.5)) refuse("needs Poisson's ratio between -1 and 0.5", poisson, "0.3 suits most");
  HexShape shape;
  shape.poisson = poisson;
  shape.rest_nodes = nodes.rowwise() - nodes.colwise().mean();
  check_not_inverted(shape.rest_nodes);

  // quadrature: the map may differ from point to point
  for (int q = 0; q < 8; ++q) {
    const Vector3d& s = quadrature_points()[q];
    const Matrix3d F = material_jacobian(shape.rest_nodes, s);
    shape.gradients[q] = shape_gradients(s) * F.inverse();
    shape.weights[q] = F.determinant();
    shape.volume += shape.weights[q];
  }

  // both energies; the paper's has the normal part of the elasticity matrix twice, the shear part once
  const Matrix6d E = elasticity_matrix(1, poisson);
  Matrix6d E_paper = E;
  E_paper.topLeftCorner<3, 3>() *= 2;
  shape.stiffness = integrate_stiffness(shape, E);
  shape.stiffness_paper = integrate_stiffness(shape, E_paper);

  // rotation estimates
  const Vector3d centre = Vector3d::Zero();
  shape.rotation_gradients[int(RotationEstimate::centre)] =
      shape_gradients(centre) * material_jacobian(shape.rest_nodes, centre).inverse();
  shape.rotation_gradients[int(RotationEstimate::tetrahedron)] =
      tetrahedron_gradients(shape.rest_nodes, inner_tetrahedron, "inner");
  shape.rotation_gradients[int(RotationEstimate::kuhn)] =
      tetrahedron_gradients(shape.rest_nodes, kuhn_tetrahedron, "Kuhn");
  return shape;
}

}  // namespace umax
