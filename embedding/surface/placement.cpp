#include "embedding/surface/placement.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"
#include "core/element/rotation.h"

namespace umax {
namespace {

[[noreturn]] void refuse(const char* key, const char* what, const std::string& value, const char* remedy) {
  throw Error(Fault::bad_data, {key, what, value, remedy});
}

double positive(const char* key, const char* remedy, double value) {
  if (!(value > 0) || !std::isfinite(value))
    refuse(key, "must be a positive number", fmt::format("{:g}", value), remedy);
  return value;
}

// cyclic turns, so that right-handed stays right-handed
Matrix3d y_up_from(const std::string& up) {
  const bool negative = !up.empty() && up[0] == '-';
  const std::string axis = negative || (!up.empty() && up[0] == '+') ? up.substr(1) : up;
  Matrix3d turn = Matrix3d::Identity();
  if (axis == "x" || axis == "X") {
    turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  } else if (axis == "z" || axis == "Z") {
    turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  } else if (axis != "y" && axis != "Y") {
    refuse("up", "must be an axis", '"' + up + '"', "give \"x\", \"y\" or \"z\"");
  }
  if (negative) turn = Vector3d(1, -1, -1).asDiagonal() * turn;  // half a turn about X
  return turn;
}

double box_height(const Points& positions) {
  return positions.col(1).maxCoeff() - positions.col(1).minCoeff();
}

}  // namespace

Placed place(TriangleMesh& mesh, const Placement& placement, Points* riders) {
  Placed placed;
  if (mesh.num_vertices() == 0) return placed;
  const auto scale_by = [&](double factor) {
    placed.scale *= factor;
    placed.placed_from_own.prescale(factor);
    mesh.positions *= factor;
    if (riders) *riders *= factor;
  };
  if (placement.unit) scale_by(positive("unit", "give the length of one file unit, such as \"cm\"", *placement.unit));
  if (!placement.rotation_degrees.allFinite()) refuse("rotation", "must be three finite angles", "", "give degrees");

  const Matrix3d turn = rotation_from_degrees(placement.rotation_degrees) * y_up_from(placement.up.value_or("y"));
  if (turn != Matrix3d::Identity()) {
    placed.placed_from_own.prerotate(turn);
    mesh.positions = (mesh.positions * turn.transpose()).eval();
    if (mesh.normals.rows() > 0) mesh.normals = (mesh.normals * turn.transpose()).eval();
    if (riders) *riders = (*riders * turn.transpose()).eval();
  }

  if (placement.height) {
    const double wanted = positive("height", "give a height such as \"2 m\"", *placement.height);
    const double height = box_height(mesh.positions);
    if (!(height > 0)) refuse("height", "cannot be reached: the placed mesh is flat", "0 m", "give a scale instead");
    scale_by(wanted / height);
  } else if (placement.scale) {
    scale_by(positive("scale", "give a factor such as 0.5", *placement.scale));
  }

  if (placement.position) {
    const Eigen::RowVector3d centre = 0.5 * (mesh.positions.colwise().minCoeff() + mesh.positions.colwise().maxCoeff());
    const Eigen::RowVector3d by = placement.position->transpose() - centre;
    placed.placed_from_own.pretranslate(by.transpose());
    mesh.positions.rowwise() += by;
    if (riders) riders->rowwise() += by;
  }
  return placed;
}

}  // namespace umax
