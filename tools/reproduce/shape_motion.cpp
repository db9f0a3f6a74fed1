#include "tools/reproduce/shape_motion.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <vector>

namespace umax {
namespace {

constexpr double independent = 1e-6;  // [-] of its length that a mode must add to those before it

/// A velocity of every node as one vector of sqrt(m) v, so that <a, b> is the dot product.
VectorXd weighted(const VectorXd& mass, const std::function<Vector3d(Eigen::Index)>& velocity) {
  VectorXd field(3 * mass.size());
  for (Eigen::Index i = 0; i < mass.size(); ++i) field.segment<3>(3 * i) = std::sqrt(mass[i]) * velocity(i);
  return field;
}

/// Takes the parts along orthonormal modes out of a field. Twice: the first time leaves rounding behind.
void remove_modes(const std::vector<VectorXd>& modes, VectorXd& field) {
  for (int round = 0; round < 2; ++round)
    for (const VectorXd& mode : modes) field -= mode.dot(field) * mode;
}

/// Makes the field one more orthonormal mode unless it is a combination of those there are.
void add_mode(VectorXd field, std::vector<VectorXd>& modes) {
  const double length = field.norm();
  remove_modes(modes, field);
  const double added = field.norm();
  if (added > independent * length) modes.push_back(field / added);
}

/// [J] of the field's part along the modes from `first` on.
double energy_along(const std::vector<VectorXd>& modes, std::size_t first, const VectorXd& field) {
  double energy = 0;
  for (std::size_t k = first; k < modes.size(); ++k) energy += 0.5 * std::pow(modes[k].dot(field), 2);
  return energy;
}

/// Velocity gradients: 3 turns, or what makes them all linear maps, 3 shears and 3 stretches.
std::vector<Matrix3d> velocity_gradients(bool turns) {
  std::vector<Matrix3d> gradients;
  for (int i = 0; i < 3; ++i) {
    Matrix3d L = Matrix3d::Zero();
    L((i + 1) % 3, (i + 2) % 3) = 1;
    L((i + 2) % 3, (i + 1) % 3) = turns ? -1 : 1;
    gradients.push_back(L);
    if (!turns) gradients.push_back(Vector3d::Unit(i).asDiagonal());
  }
  return gradients;
}

}  // namespace

ShapeMotion shape_motion(const Model& model, const Model::BodyRange& body, const State& state) {
  const auto positions = state.positions.middleRows(body.first_node, body.num_nodes);
  const auto velocities = state.velocities.middleRows(body.first_node, body.num_nodes);
  const VectorXd mass = model.node_mass.segment(body.first_node, body.num_nodes);
  const Vector3d centre = positions.transpose() * mass / mass.sum();
  std::vector<VectorXd> modes;
  const auto add_gradients = [&](bool turns) {
    for (const Matrix3d& L : velocity_gradients(turns))
      add_mode(weighted(mass, [&](Eigen::Index i) -> Vector3d { return L * (positions.row(i).transpose() - centre); }),
               modes);
  };
  VectorXd field = weighted(mass, [&](Eigen::Index i) -> Vector3d { return velocities.row(i); });
  ShapeMotion motion;

  // translations and turns, then what else a linear map does, then what is left
  for (int axis = 0; axis < 3; ++axis)
    add_mode(weighted(mass, [&](Eigen::Index) -> Vector3d { return Vector3d::Unit(axis); }), modes);
  add_gradients(true);
  motion.rigid = energy_along(modes, 0, field);
  const std::size_t num_rigid = modes.size();
  add_gradients(false);
  motion.affine = energy_along(modes, num_rigid, field);
  remove_modes(modes, field);
  motion.waves = 0.5 * field.squaredNorm();
  return motion;
}

}  // namespace umax
