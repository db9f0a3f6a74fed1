// Which point of a body's material is at a point of space: the trilinear map of a deformed hex, inverted.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "core/model/model.h"

namespace umax {

/// A hex and this much of its size around it: trilinear maps continue there.
inline constexpr double within_hex = 1 + 1e-9, around_hex = 2;

struct MaterialPoint {
  Vector8d weights = Vector8d::Zero();        // of the hex's nodes
  Vector3d rest = Vector3d::Zero();           // [m] where the material is at rest
  Matrix3d F_inverse = Matrix3d::Identity();  // of the deformation gradient there
};

/// A trilinear map of local coordinates s as a polynomial: the columns are the factors of 1, s0, s1, s2, s1 s2, s0 s2, s0 s1,
/// s0 s1 s2.
using TrilinearMap = Eigen::Matrix<double, 3, 8>;

/// Where a hex has its material [m], deformed and at rest.
struct HexMaps {
  int hex = 0;
  TrilinearMap world, rest;
};
HexMaps hex_maps(const Model& model, const Points& positions, int hex);

/// Local coordinates of the point in the hex, by Newton's method; none: there are none near it.
std::optional<Vector3d> find_local(const HexMaps& maps, const Vector3d& point);

/// Is material of the hex there? Not where that is more than `reach` half sizes from the hex's centre along an axis, or where
/// the hex is turned inside out.
bool has_material(const HexMaps& maps, const Vector3d& s, double reach);

/// That material, and where alone it is at rest [m].
MaterialPoint material_at(const HexMaps& maps, const Vector3d& s);
Vector3d rest_place(const HexMaps& maps, const Vector3d& s);

/// The material of the hex at a point; false where it has none there.
bool find_material(const HexMaps& maps, const Vector3d& point, double reach, MaterialPoint& material);

/// What others hit of a body that has a surface.
inline ScaledSurface surface_of(const Model::BodyRange& body) {
  return {*body.rest_surface, body.rest_scale};
}

/// Of a point from a box [m^2].
inline double squared_distance(const Eigen::AlignedBox3d& box, const Vector3d& point) {
  return (box.min() - point).cwiseMax(point - box.max()).cwiseMax(0.0).squaredNorm();
}

/// By how much the matrix makes vectors longer, at most; just that where it turns and scales.
double stretch_bound(const Matrix3d& M);

/// Bounds of where find_material() finds points of a hex, at the cost of a product: the trilinear map differs from an
/// affine one by no more than it does at the corners.
struct HexBounds {
  HexMaps maps;
  Eigen::AlignedBox3d box;                     // of the deformed hex
  Matrix3d rest_from_world, local_from_world;  // of the affine map
  Vector3d centre, rest_centre;                // [m]
  double rest_stretch = 0, local_stretch = 0;  // [-], [1/m] by which these make vectors longer, at most
  double rest_error = 0;                       // [m] of the material that the affine map gives; infinity: no bound
  double local_error = 0;                      // [-] of local coordinates, each
  double largest_inverse = 0;                  // [-] by which F^-1 makes vectors longer in the hex, at most
  double bend = 0;  // [-] norm of E, the map's gradient being A (1 + E), A that of the affine one; infinity: no bound
  Vector3d local_lengths;  // [m] by which a coordinate grows by 1 along its gradient in the affine map
  DistanceView distances;  // from the body's surface at rest, of places from the centre on, by the affine map
};
HexBounds bound_hex(const Model& model, const Points& positions, int hex);

/// How far [m] the point is at least from where the hex may hold points; 0: it may hold this one.
double distance_from(const HexBounds& bounds, const Vector3d& point);

/// How far [m] the point with these local coordinates, which the hex does not hold, is at least from where it may hold
/// points; 0: nothing is known.
double distance_beyond(const HexBounds& bounds, const Vector3d& s);

/// May the hex hold a point of another hex with these nodes, if all nodes of both move by no more than `by` [m]?
bool may_meet(const HexBounds& bounds, const Matrix8x3d& nodes, double by);

}  // namespace umax
