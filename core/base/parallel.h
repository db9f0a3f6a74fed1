// Parallel loops whose results do not depend on the number of threads: over fixed blocks, each done by one thread.
#pragma once

#include <functional>

#include "core/base/types.h"

namespace umax {

/// Calls body(begin, end) for consecutive blocks of `grain` indices that cover [0, count), in any order, in parallel.
/// Runs on the calling thread when there is one block only.
void parallel_blocks(Eigen::Index count, Eigen::Index grain,
                     const std::function<void(Eigen::Index, Eigen::Index)>& body);

/// Calls body(i) for i = 0 .. count - 1, in parallel but begun in this order: with the longest first, all end soonest. What
/// waits inside a body for others takes no further body meanwhile.
void parallel_in_order(Eigen::Index count, const std::function<void(Eigen::Index)>& body);

}  // namespace umax
