#include "core/element/hex_batch_kernel.h"

namespace umax {
namespace portable {
extern const HexBatchKernels hex_batch_kernels;
}  // namespace portable
#ifdef UMAX_X86_KERNELS
namespace avx2 {
extern const HexBatchKernels hex_batch_kernels;
}  // namespace avx2
namespace avx512 {
extern const HexBatchKernels hex_batch_kernels;
}  // namespace avx512
#endif

const HexBatchKernels& hex_batch_kernels(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::hex_batch_kernels;
  if (set == InstructionSet::avx2) return avx2::hex_batch_kernels;
#endif
  (void)set;
  return portable::hex_batch_kernels;
}

}  // namespace umax
