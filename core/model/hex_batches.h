// A model's hexes in batches (core/element/hex_batch.h).
#pragma once

#include "core/element/hex_batch.h"
#include "core/model/model.h"

namespace umax {

/// Calls visit(hex, batch, lane) for the hexes [begin, end), one after the other, each evaluated at the positions.
template <class Visit>
void evaluate_hexes(const Model& model, RotationEstimate estimate, const Points& positions, Eigen::Index begin,
                    Eigen::Index end, const Visit& visit) {
  HexBatch batch;
  for (Eigen::Index first = begin; first < end;) {
    int count = 0;
    for (; count < most_batched && first + count < end; ++count) {
      if (model.hex_shape[first + count] != model.hex_shape[first]) break;
      set_nodes(hex_nodes(model, positions, first + count), count, batch);
    }
    evaluate(model.shapes[model.hex_shape[first]], estimate, count, batch);
    for (int lane = 0; lane < count; ++lane) visit(first + lane, batch, lane);
    first += count;
  }
}

}  // namespace umax
