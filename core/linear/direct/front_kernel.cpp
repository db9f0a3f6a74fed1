#include "core/linear/direct/front_kernel.h"

#include "core/base/kernel_choice.h"

namespace umax {

const FrontKernels& front_kernels(InstructionSet set) {
  return chosen_kernels<FrontKernels>(set);
}

}  // namespace umax
