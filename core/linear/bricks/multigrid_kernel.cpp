#include "core/linear/bricks/multigrid_kernel.h"

namespace umax {
namespace portable {
extern const MultigridKernels grid_kernels;
}  // namespace portable
#ifdef UMAX_X86_KERNELS
namespace avx2 {
extern const MultigridKernels grid_kernels;
}  // namespace avx2
namespace avx512 {
extern const MultigridKernels grid_kernels;
}  // namespace avx512
#endif

const MultigridKernels& multigrid_kernels(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::grid_kernels;
  if (set == InstructionSet::avx2) return avx2::grid_kernels;
#endif
  (void)set;
  return portable::grid_kernels;
}

}  // namespace umax
