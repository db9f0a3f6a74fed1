// The inner loops of core/element/hex_batch.h, compiled once for each instruction set and chosen at run time. The
// mathematics, and the symbols, are those of core/element/elastic_energy.h and of rotation.cpp. Plain data, which the
// kernels of every instruction set read.
#pragma once

#include "core/base/instruction_set.h"

namespace umax {

inline constexpr int most_batched = 8;  // hexes

/// Numbers of up to eight hexes side by side. A node's component c is number 3 node + c; entry (r, c) of a matrix is
/// 3 r + c.
struct HexBatch {
  alignas(64) double nodes[24][most_batched];         // [m] x
  alignas(64) double rotation[9][most_batched];       // R
  alignas(64) double stretch[9][most_batched];        // S
  alignas(64) double local_nodes[24][most_batched];   // [m] y
  alignas(64) double displacement[24][most_batched];  // [m] u
  alignas(64) double energy[most_batched];            // [J] U for a Young's modulus of 1 Pa
  alignas(64) double gradient[24][most_batched];      // [N] dU/dx, likewise
  unsigned unresolved = 0;  // bit of a lane whose rotation, or how it moves, is nearly undetermined: not filled
};

/// Of HexShape: K, h_j and X_j.
struct HexBatchShape {
  const double *stiffness = nullptr, *rotation_gradients = nullptr, *rest_nodes = nullptr;
};

struct HexBatchKernels {
  void (*evaluate)(const HexBatchShape& shape, HexBatch& batch) = nullptr;
  /// gradient = R K R^T nodes, where nodes are motions.
  void (*multiply_warped)(const HexBatchShape& shape, HexBatch& batch) = nullptr;
};

const HexBatchKernels& hex_batch_kernels(InstructionSet set);

}  // namespace umax
