// Loops over fixed blocks on all threads. A block's result never depends on which thread runs it.
#pragma once

#include <functional>

#include "core/base/types.h"

namespace umax {

/// Calls body(begin, end) for consecutive blocks of `grain` indices that cover [0, count), in any order, in parallel.
/// Runs on the calling thread when there is one block only.
void parallel_blocks(Eigen::Index count, Eigen::Index grain,
                     const std::function<void(Eigen::Index, Eigen::Index)>& body);

}  // namespace umax
