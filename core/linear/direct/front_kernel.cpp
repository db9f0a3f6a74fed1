#include "core/linear/direct/front_kernel.h"

namespace umax {
namespace portable {
extern const FrontKernels front_kernels;
}  // namespace portable
#ifdef UMAX_X86_KERNELS
namespace avx2 {
extern const FrontKernels front_kernels;
}  // namespace avx2
namespace avx512 {
extern const FrontKernels front_kernels;
}  // namespace avx512
#endif

const FrontKernels& front_kernels(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::front_kernels;
  if (set == InstructionSet::avx2) return avx2::front_kernels;
#endif
  (void)set;
  return portable::front_kernels;
}

}  // namespace umax
