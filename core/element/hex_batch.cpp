#include "core/element/hex_batch.h"

#include <algorithm>

namespace umax {
namespace {

template <class Values>
void set_lane(const Values& values, int lane, double (*to)[most_batched]) {
  for (Eigen::Index i = 0; i < values.size(); ++i) to[i][lane] = values.data()[i];
}

Matrix3d matrix_in(const double (&from)[9][most_batched], int lane) {
  Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = from[i][lane];
  return matrix;
}

// lanes that have no hex, as the first one
template <int rows>
void fill_up(int count, double (&values)[rows][most_batched]) {
  for (auto& row : values) std::fill(row + count, row + most_batched, row[0]);
}

void evaluate_alone(const HexShape& shape, RotationEstimate estimate, int lane, HexBatch& batch) {
  Matrix8x3d x;
  for (int i = 0; i < 24; ++i) x.data()[i] = batch.nodes[i][lane];
  const CorotatedHex hex = corotate(shape, estimate, x);
  const EnergyWithGradient elastic =
      energy_with_gradient(shape.stiffness, 1, shape.rotation_gradients[int(estimate)], hex);
  for (int i = 0; i < 9; ++i) {
    batch.rotation[i][lane] = hex.rotation(i / 3, i % 3);
    batch.stretch[i][lane] = hex.stretch(i / 3, i % 3);
  }
  set_lane(hex.local_nodes, lane, batch.local_nodes);
  set_lane(hex.displacement, lane, batch.displacement);
  set_lane(elastic.gradient, lane, batch.gradient);
  batch.energy[lane] = elastic.energy;
}

}  // namespace

void set_nodes(const Matrix8x3d& x, int lane, HexBatch& batch) {
  set_lane(x, lane, batch.nodes);
}

void evaluate(const HexShape& shape, RotationEstimate estimate, int count, HexBatch& batch) {
  fill_up(count, batch.nodes);
  hex_batch_kernels(best_instruction_set())
      .evaluate({shape.stiffness.data(), shape.rotation_gradients[int(estimate)].data(), shape.rest_nodes.data()},
                batch);
  for (int lane = 0; batch.unresolved != 0 && lane < count; ++lane)
    if (batch.unresolved >> lane & 1) evaluate_alone(shape, estimate, lane, batch);
  batch.unresolved = 0;
}

void set_rotation(const Matrix3d& rotation, int lane, HexBatch& batch) {
  for (int i = 0; i < 9; ++i) batch.rotation[i][lane] = rotation(i / 3, i % 3);
}

void multiply_warped(const HexShape& shape, int count, HexBatch& batch) {
  fill_up(count, batch.nodes);
  fill_up(count, batch.rotation);
  hex_batch_kernels(best_instruction_set()).multiply_warped({shape.stiffness.data(), nullptr, nullptr}, batch);
}

CorotatedHex corotated_hex(const HexBatch& batch, int lane) {
  CorotatedHex hex{.rotation = rotation_of(batch, lane), .stretch = matrix_in(batch.stretch, lane)};
  for (int i = 0; i < 24; ++i) {
    hex.local_nodes.data()[i] = batch.local_nodes[i][lane];
    hex.displacement[i] = batch.displacement[i][lane];
  }
  return hex;
}

Matrix3d rotation_of(const HexBatch& batch, int lane) {
  return matrix_in(batch.rotation, lane);
}

double elastic_energy(double young, const HexBatch& batch, int lane) {
  return young * batch.energy[lane];
}

Vector24d elastic_gradient(double young, const HexBatch& batch, int lane) {
  Vector24d gradient;
  for (int i = 0; i < 24; ++i) gradient[i] = young * batch.gradient[i][lane];
  return gradient;
}

}  // namespace umax
