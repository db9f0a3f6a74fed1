#include "core/linear/bricks/hex_kernel.h"

namespace umax {
namespace portable {
extern const HexKernels kernels;
}  // namespace portable
#ifdef UMAX_X86_KERNELS
namespace avx2 {
extern const HexKernels kernels;
}  // namespace avx2
namespace avx512 {
extern const HexKernels kernels;
}  // namespace avx512
#endif

const HexKernels& hex_kernels(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::kernels;
  if (set == InstructionSet::avx2) return avx2::kernels;
#endif
  (void)set;
  return portable::kernels;
}

}  // namespace umax
