#include "core/base/parallel.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace umax {

void parallel_blocks(Eigen::Index count, Eigen::Index grain,
                     const std::function<void(Eigen::Index, Eigen::Index)>& body) {
  const Eigen::Index num_blocks = (count + grain - 1) / grain;
  if (num_blocks <= 1) {
    if (count > 0) body(0, count);
    return;
  }
  tbb::parallel_for(Eigen::Index(0), num_blocks,
                    [&](Eigen::Index b) { body(b * grain, std::min(count, (b + 1) * grain)); });
}

}  // namespace umax
