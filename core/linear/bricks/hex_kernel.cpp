#include "core/linear/bricks/hex_kernel.h"

#include <initializer_list>

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

bool is_supported(InstructionSet set) {
  switch (set) {
    case InstructionSet::portable:
      return true;
#ifdef UMAX_X86_KERNELS
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
#endif
    default:
      return false;
  }
}

InstructionSet best_instruction_set() {
  for (const InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2})
    if (is_supported(set)) return set;
  return InstructionSet::portable;
}

const HexKernels& hex_kernels(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::kernels;
  if (set == InstructionSet::avx2) return avx2::kernels;
#endif
  (void)set;
  return portable::kernels;
}

}  // namespace umax
