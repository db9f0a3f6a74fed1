// In which order the nodes' unknowns are eliminated by a direct solver.
#pragma once

#include <vector>

#include "core/model.h"

namespace umax {

/// All nodes in a fill-reducing order in which subtrees of the elimination tree stay together; those in `last`
/// (ascending) come after everything that they depend on: all that is eliminated after one of them is in `last` too.
std::vector<int> elimination_order(const Model& model, const std::vector<int>& last);

}  // namespace umax
