#include "core/contact/material_point.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace umax {
namespace {

constexpr double settled = 1e-8;  // [-] change of a local coordinate, beyond which Newton's method has its square left

double sign_of(int corner, int axis) {
  return corner & (4 >> axis) ? 1 : -1;
}

Eigen::Matrix<double, 8, 8> polynomial_of_corners() {
  Eigen::Matrix<double, 8, 8> factors;
  for (int n = 0; n < 8; ++n) {
    const double a = sign_of(n, 0), b = sign_of(n, 1), c = sign_of(n, 2);
    factors.row(n) << 1, a, b, c, b * c, a * c, a * b, a * b * c;
  }
  return factors / 8;
}

TrilinearMap trilinear(const Matrix8x3d& nodes) {
  static const Eigen::Matrix<double, 8, 8> factors = polynomial_of_corners();
  return nodes.transpose() * factors;
}

Vector3d place(const TrilinearMap& map, const Vector3d& s) {
  return map.col(0) + s[0] * map.col(1) + s[1] * map.col(2) + s[2] * map.col(3) + s[1] * s[2] * map.col(4) +
         s[0] * s[2] * map.col(5) + s[0] * s[1] * map.col(6) + s[0] * s[1] * s[2] * map.col(7);
}

Matrix3d gradient(const TrilinearMap& map, const Vector3d& s) {
  Matrix3d columns;
  columns.col(0) = map.col(1) + s[2] * map.col(5) + s[1] * map.col(6) + s[1] * s[2] * map.col(7);
  columns.col(1) = map.col(2) + s[2] * map.col(4) + s[0] * map.col(6) + s[0] * s[2] * map.col(7);
  columns.col(2) = map.col(3) + s[1] * map.col(4) + s[0] * map.col(5) + s[0] * s[1] * map.col(7);
  return columns;
}

}  // namespace

HexMaps hex_maps(const Model& model, const Points& positions, int hex) {
  return {hex, trilinear(hex_nodes(model, positions, hex)), trilinear(hex_nodes(model, model.rest_positions, hex))};
}

std::optional<Vector3d> find_local(const HexMaps& maps, const Vector3d& point) {
  Vector3d s = Vector3d::Zero();
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Matrix3d jacobian = gradient(maps.world, s);
    if (!(std::abs(jacobian.determinant()) > 0)) return {};
    const Vector3d change = jacobian.inverse() * (place(maps.world, s) - point);
    s -= change;
    if (!(s.cwiseAbs().maxCoeff() < 4)) return {};
    if (change.cwiseAbs().maxCoeff() < settled) return s;
  }
  return {};
}

bool has_material(const HexMaps& maps, const Vector3d& s, double reach) {
  return s.cwiseAbs().maxCoeff() <= reach &&
         gradient(maps.world, s).determinant() * gradient(maps.rest, s).determinant() > 0;
}

MaterialPoint material_at(const HexMaps& maps, const Vector3d& s) {
  const Matrix3d F = gradient(maps.world, s) * gradient(maps.rest, s).inverse();
  return {shape_functions(s), rest_place(maps, s), F.inverse()};
}

Vector3d rest_place(const HexMaps& maps, const Vector3d& s) {
  return place(maps.rest, s);
}

bool find_material(const HexMaps& maps, const Vector3d& point, double reach, MaterialPoint& material) {
  const std::optional<Vector3d> s = find_local(maps, point);
  if (!s || !has_material(maps, *s, reach)) return false;
  material = material_at(maps, *s);
  return true;
}

// The largest singular value squared is no more than the largest sum of absolute values in a row of M^T M.
double stretch_bound(const Matrix3d& M) {
  return std::sqrt((M.transpose() * M).cwiseAbs().rowwise().sum().maxCoeff());
}

HexBounds bound_hex(const Model& model, const Points& positions, int hex) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Matrix8x3d nodes = hex_nodes(model, positions, hex), rest = hex_nodes(model, model.rest_positions, hex);
  HexBounds bounds;
  bounds.maps = {hex, trilinear(nodes), trilinear(rest)};
  for (int n = 0; n < 8; ++n) bounds.box.extend(nodes.row(n).transpose());
  bounds.centre = nodes.colwise().mean().transpose();
  bounds.rest_centre = rest.colwise().mean().transpose();
  const Matrix8x3d at_centre = shape_gradients(Vector3d::Zero());
  const Matrix3d A = nodes.transpose() * at_centre, H = rest.transpose() * at_centre;  // of local coordinates
  bounds.rest_error = bounds.local_error = bounds.largest_inverse = bounds.bend = infinity;
  if (body_of(model, hex).cells.rows() == 0 || !(std::abs(A.determinant()) > 0)) return bounds;
  const Matrix3d A_inverse = A.inverse();
  bounds.rest_from_world = H * A_inverse;
  bounds.local_from_world = A_inverse;
  bounds.rest_stretch = stretch_bound(bounds.rest_from_world);
  bounds.local_stretch = stretch_bound(A_inverse);
  bounds.local_lengths = A_inverse.rowwise().norm().cwiseInverse();
  const Matrix3d edges = H.diagonal() * H.diagonal().cwiseInverse().transpose();  // ratios of the cell's
  bounds.rest_error = bounds.local_error = bounds.bend = 0;
  double rest_bend = 0;  // of the map back to rest
  for (int n = 0; n < 8; ++n) {
    const Vector3d s(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1);
    const Vector3d error = A_inverse * (nodes.row(n).transpose() - bounds.centre) - s;
    const Matrix3d E = A_inverse * (nodes.transpose() * shape_gradients(s)) - Matrix3d::Identity();
    bounds.local_error = std::max(bounds.local_error, error.cwiseAbs().maxCoeff());
    bounds.rest_error = std::max(bounds.rest_error, (H * error).norm());
    bounds.bend = std::max(bounds.bend, E.norm());
    rest_bend = std::max(rest_bend, E.cwiseProduct(edges).norm());
  }
  if (rest_bend < 1) bounds.largest_inverse = bounds.rest_stretch / (1 - rest_bend);
  const Model::BodyRange& body = body_of(model, hex);
  if (body.rest_surface)
    bounds.distances = view_distances(surface_of(body), body.rest_pose.rotation.transpose() * bounds.rest_from_world,
                                      body.rest_pose.local(bounds.rest_centre));
  return bounds;
}

double distance_from(const HexBounds& bounds, const Vector3d& point) {
  const double squared = squared_distance(bounds.box, point);
  if (squared > 0 || !std::isfinite(bounds.local_error)) return std::sqrt(squared);
  double distance = 0;
  const Vector3d local = bounds.local_from_world * (point - bounds.centre);
  for (int axis = 0; axis < 3; ++axis) {
    const double beyond = std::abs(local[axis]) - (within_hex + bounds.local_error);
    if (beyond > 0) distance = std::max(distance, beyond * bounds.local_lengths[axis]);
  }
  return distance;
}

// With  x = c + A (s + e(s)),  the gradient of e is odd and even terms of first and second degree in s, which grow to no more
// than m^2 times what they are in the hex where coordinates go up to m. While that is below 1, no two places there have one
// x, and on the straight way from the hex to a point with coordinate m they grow by at least m - 1.
double distance_beyond(const HexBounds& bounds, const Vector3d& s) {
  if (!std::isfinite(bounds.bend)) return 0;
  const double most = s.cwiseAbs().maxCoeff(), left = 1 - most * most * bounds.bend;
  return most > within_hex && left > 0 ? (most - within_hex) * left / bounds.local_stretch : 0;
}

bool may_meet(const HexBounds& bounds, const Matrix8x3d& nodes, double by) {
  if (!std::isfinite(bounds.local_error)) return true;
  // both move: the point and the hex's centre by `by`, and a corner of the affine map by sqrt(3) times as much
  const double reach = within_hex + bounds.local_error + (2 + std::sqrt(3)) * bounds.local_stretch * by;
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int n = 0; n < 8; ++n) {
    const Vector3d local = bounds.local_from_world * (nodes.row(n).transpose() - bounds.centre);
    low = low.cwiseMin(local);
    high = high.cwiseMax(local);
  }
  return (low.array() <= reach).all() && (high.array() >= -reach).all();
}

}  // namespace umax
