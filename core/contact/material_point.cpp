#include "core/contact/material_point.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace umax {
namespace {

// local coordinates s with sum_n N_n(s) x_n = point; false if |s| > reach
bool invert_trilinear(const Matrix8x3d& nodes, const Vector3d& point, double reach, Vector3d& s) {
  s.setZero();
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vector3d residual = nodes.transpose() * shape_functions(s) - point;
    const Matrix3d jacobian = nodes.transpose() * shape_gradients(s);
    if (!(std::abs(jacobian.determinant()) > 0)) return false;
    const Vector3d change = jacobian.inverse() * residual;
    s -= change;
    if (!(s.cwiseAbs().maxCoeff() < 4)) return false;
    if (change.cwiseAbs().maxCoeff() < 1e-12) return s.cwiseAbs().maxCoeff() <= reach;
  }
  return false;
}

}  // namespace

bool find_material(const Model& model, const Points& positions, int hex, const Vector3d& point, double reach,
                   MaterialPoint& material) {
  const Matrix8x3d nodes = hex_nodes(model, positions, hex);
  Vector3d s;
  if (!invert_trilinear(nodes, point, reach, s)) return false;
  const Matrix8x3d rest = hex_nodes(model, model.rest_positions, hex);
  const Matrix8x3d gradients = shape_gradients(s);
  const Matrix3d F = (nodes.transpose() * gradients) * (rest.transpose() * gradients).inverse();
  if (!(F.determinant() > 0)) return false;
  material.weights = shape_functions(s);
  material.rest = rest.transpose() * material.weights;
  material.F_inverse = F.inverse();
  return true;
}

HexBounds bound_hex(const Model& model, const Points& positions, int hex) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Matrix8x3d nodes = hex_nodes(model, positions, hex), rest = hex_nodes(model, model.rest_positions, hex);
  HexBounds bounds;
  for (int n = 0; n < 8; ++n) bounds.box.extend(nodes.row(n).transpose());
  bounds.centre = nodes.colwise().mean().transpose();
  bounds.rest_centre = rest.colwise().mean().transpose();
  const Matrix8x3d at_centre = shape_gradients(Vector3d::Zero());
  const Matrix3d A = nodes.transpose() * at_centre, H = rest.transpose() * at_centre;  // of local coordinates
  bounds.rest_error = bounds.local_error = bounds.largest_inverse = bounds.largest_stretch = infinity;
  if (model.bodies[model.hex_body[hex]].cells.rows() == 0 || !(std::abs(A.determinant()) > 0)) return bounds;
  const Matrix3d A_inverse = A.inverse();
  bounds.rest_from_world = H * A_inverse;
  bounds.local_from_world = A_inverse;
  double error = 0, bend = 0;  // of the map, and of its gradient
  for (int n = 0; n < 8; ++n) {
    const Vector3d s(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1);
    error = std::max(error, (nodes.row(n).transpose() - bounds.centre - A * s).norm());
    bend = std::max(bend, (A_inverse * (nodes.transpose() * shape_gradients(s) - A)).norm());
  }
  bounds.rest_error = bounds.rest_from_world.norm() * error;
  bounds.local_error = A_inverse.norm() * error;
  bounds.largest_stretch = (A * H.inverse()).norm() * (1 + bend);
  if (bend < 1) bounds.largest_inverse = bounds.rest_from_world.norm() / (1 - bend);
  return bounds;
}

bool may_hold(const HexBounds& bounds, const Vector3d& point, double radius) {
  if (bounds.box.squaredExteriorDistance(point) > radius * radius) return false;
  if (!std::isfinite(bounds.local_error)) return true;
  const Vector3d local = bounds.local_from_world * (point - bounds.centre);
  const double error = bounds.local_error + (radius > 0 ? bounds.local_from_world.norm() * radius : 0);
  return local.cwiseAbs().maxCoeff() <= within_hex + error;
}

bool may_meet(const HexBounds& bounds, const Matrix8x3d& nodes, double by) {
  if (!std::isfinite(bounds.local_error)) return true;
  // both move: the point and the hex's centre by `by`, and a corner of the affine map by sqrt(3) times as much
  const double reach = within_hex + bounds.local_error + (2 + std::sqrt(3)) * bounds.local_from_world.norm() * by;
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int n = 0; n < 8; ++n) {
    const Vector3d local = bounds.local_from_world * (nodes.row(n).transpose() - bounds.centre);
    low = low.cwiseMin(local);
    high = high.cwiseMax(local);
  }
  return (low.array() <= reach).all() && (high.array() >= -reach).all();
}

}  // namespace umax
