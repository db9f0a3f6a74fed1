#include "core/linear/bricks/multigrid_kernel.h"

#include "core/base/kernel_choice.h"

namespace umax {

const MultigridKernels& multigrid_kernels(InstructionSet set) {
  return chosen_kernels<MultigridKernels>(set);
}

}  // namespace umax
