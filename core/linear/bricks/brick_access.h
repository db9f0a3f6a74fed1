// Single nodes and hexes of arrays in bricks: to read them, to write them, and to add a hex's stiffness to a matrix.
// A slot says where a node or a cell stands (core/linear/bricks/brick_lattice.h).
#pragma once

#include <array>
#include <vector>

#include "core/linear/bricks/aligned_array.h"
#include "core/linear/bricks/brick_lattice.h"

namespace umax {

/// The three values of the node in a slot.
template <class T>
Eigen::Matrix<T, 3, 1> node_value(const AlignedArray<T>& x, int slot) {
  const T* at = x.data() + slot_offset(slot, vector_components);
  return {at[0], at[brick_lanes], at[2 * brick_lanes]};
}

template <class T>
void set_node_value(int slot, const Eigen::Matrix<T, 3, 1>& value, AlignedArray<T>& x) {
  T* at = x.data() + slot_offset(slot, vector_components);
  for (int c = 0; c < 3; ++c) at[c * brick_lanes] = value[c];
}

/// x += value, at the node in a slot.
inline void add_at_node(int slot, const Vector3f& value, AlignedArray<float>& x) {
  float* at = x.data() + slot_offset(slot, vector_components);
  for (int c = 0; c < 3; ++c) at[c * brick_lanes] += value[c];
}

/// The 24 values of a hex's nodes; nodes: slots.
inline Eigen::Matrix<float, 24, 1> gather_nodes(const std::array<int, 8>& nodes, const AlignedArray<float>& x) {
  Eigen::Matrix<float, 24, 1> local;
  for (int n = 0; n < 8; ++n) local.segment<3>(3 * n) = node_value(x, nodes[n]);
  return local;
}

/// x += local, at a hex's nodes.
inline void add_at_nodes(const std::array<int, 8>& nodes, const Eigen::Matrix<float, 24, 1>& local,
                         AlignedArray<float>& x) {
  for (int n = 0; n < 8; ++n) add_at_node(nodes[n], local.segment<3>(3 * n), x);
}

/// Node values (3 #N, Lattice's order) to bricks and back; slots: node_slots().
template <class T>
void to_bricks(const std::vector<int>& slots, const VectorXd& values, AlignedArray<T>& bricks) {
  for (std::size_t node = 0; node < slots.size(); ++node)
    set_node_value<T>(slots[node], values.segment<3>(3 * Eigen::Index(node)).cast<T>(), bricks);
}
template <class T>
void from_bricks(const std::vector<int>& slots, const AlignedArray<T>& bricks, VectorXd& values) {
  values.resize(3 * Eigen::Index(slots.size()));
  for (std::size_t node = 0; node < slots.size(); ++node)
    values.segment<3>(3 * Eigen::Index(node)) = node_value(bricks, slots[node]).template cast<double>();
}

/// The block D^-1 of the node in a slot, from 6 numbers per node.
inline Matrix3f inverse_block(const AlignedArray<float>& inverse, int slot) {
  const float* d = inverse.data() + slot_offset(slot, inverse_components);
  Matrix3f block;
  block << d[0], d[brick_lanes], d[2 * brick_lanes],           //
      d[brick_lanes], d[3 * brick_lanes], d[4 * brick_lanes],  //
      d[2 * brick_lanes], d[4 * brick_lanes], d[5 * brick_lanes];
  return block;
}

/// The frame Q = sqrt(s) R of the cell in a slot; zero where there is none.
template <class S>
Matrix3d frame_at(const AlignedArray<S>& frames, int slot) {
  const S* at = frames.data() + slot_offset(slot, frame_components);
  Matrix3d Q;
  for (int r = 0; r < frame_components; ++r) Q(r / 3, r % 3) = double(at[r * brick_lanes]);
  return Q;
}

template <class S>
void set_frame_at(int slot, const Matrix3d& Q, AlignedArray<S>& frames) {
  S* at = frames.data() + slot_offset(slot, frame_components);
  for (int r = 0; r < frame_components; ++r) at[r * brick_lanes] = S(Q(r / 3, r % 3));
}

/// A += Q K Q^T with Q in each of a hex's nodes, node m in the 3 rows from 3 rows[m] on, node n in the columns from
/// 3 columns[n] on; -1: left out.
template <class Matrix>
void add_turned_stiffness(const Matrix3d& Q, const Matrix24d& K, const std::array<int, 8>& rows,
                          const std::array<int, 8>& columns, Matrix& A) {
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n)
      if (rows[m] >= 0 && columns[n] >= 0)
        A.template block<3, 3>(3 * rows[m], 3 * columns[n]) += Q * K.block<3, 3>(3 * m, 3 * n) * Q.transpose();
}

}  // namespace umax
