#include "core/element/hex_batch_kernel.h"

#include "core/base/kernel_choice.h"

namespace umax {

const HexBatchKernels& hex_batch_kernels(InstructionSet set) {
  return chosen_kernels<HexBatchKernels>(set);
}

}  // namespace umax
