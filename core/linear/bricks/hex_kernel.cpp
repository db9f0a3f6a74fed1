#include "core/linear/bricks/hex_kernel.h"

#include "core/base/kernel_choice.h"

namespace umax {

const HexKernels& hex_kernels(InstructionSet set) {
  return chosen_kernels<HexKernels>(set);
}

}  // namespace umax
