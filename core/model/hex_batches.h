// A model's hexes in batches (core/element/hex_batch.h).
#pragma once

#include "core/element/hex_batch.h"
#include "core/model/model.h"

namespace umax {

/// Calls visit(first, count) for groups of hexes that cover [begin, end): as many as a batch holds, of one shape.
template <class Visit>
void for_each_group(const Model& model, Eigen::Index begin, Eigen::Index end, const Visit& visit) {
  for (Eigen::Index first = begin; first < end;) {
    int count = 1;
    while (count < most_batched && first + count < end && model.hex_shape[first + count] == model.hex_shape[first])
      ++count;
    visit(first, count);
    first += count;
  }
}

/// Calls visit(hex, batch, lane) for the hexes [begin, end), one after the other, each evaluated at the positions.
template <class Visit>
void evaluate_hexes(const Model& model, RotationEstimate estimate, const Points& positions, Eigen::Index begin,
                    Eigen::Index end, const Visit& visit) {
  HexBatch batch;
  for_each_group(model, begin, end, [&](Eigen::Index first, int count) {
    for (int lane = 0; lane < count; ++lane) set_nodes(hex_nodes(model, positions, first + lane), lane, batch);
    evaluate(model.shapes[model.hex_shape[first]], estimate, count, batch);
    for (int lane = 0; lane < count; ++lane) visit(first + lane, batch, lane);
  });
}

}  // namespace umax
