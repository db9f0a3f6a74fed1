#include "tools/pictures/hex_stress.h"

#include <cmath>

#include "core/base/parallel.h"
#include "core/element/elastic_energy.h"
#include "core/element/material.h"

namespace umax {
namespace {

/// [-] mean over the hex.
Matrix3d mean_strain(const HexShape& shape, const Vector24d& displacement) {
  Matrix3d gradient = Matrix3d::Zero();
  for (std::size_t q = 0; q < shape.weights.size(); ++q)
    for (int j = 0; j < 8; ++j)
      gradient += shape.weights[q] / shape.volume * displacement.segment<3>(3 * j) * shape.gradients[q].row(j);
  return (gradient + gradient.transpose()) / 2;
}

}  // namespace

HexStress hex_stress(const Simulation& simulation, const State& state) {
  const Model& model = simulation.model;
  HexStress result;
  result.energy.resize(model.num_hexes());
  result.stress.resize(std::size_t(model.num_hexes()));
  parallel_blocks(model.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const double young = young_at(model, e, state.time);
      const CorotatedHex hex =
          corotate(shape, simulation.options.solver.rotation, hex_nodes(model, state.positions, e));
      const Moduli material = moduli(young, shape.poisson);
      const Matrix3d strain = mean_strain(shape, hex.displacement);
      const Matrix3d local = material.E2 * strain.trace() * Matrix3d::Identity() + 2 * material.E3 * strain;
      result.energy[e] = std::max(elastic_energy(shape.stiffness, young, hex), 0.0);  // rounding may leave it below 0
      result.stress[std::size_t(e)] = hex.rotation * local * hex.rotation.transpose();
    }
  });
  return result;
}

double von_mises(const Matrix3d& stress) {
  const Matrix3d deviator = stress - stress.trace() / 3 * Matrix3d::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

}  // namespace umax
