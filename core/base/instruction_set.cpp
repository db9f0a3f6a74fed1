#include "core/base/instruction_set.h"

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>

namespace umax {
namespace {

InstructionSet widest_allowed = InstructionSet::avx512;

}  // namespace

bool is_supported(InstructionSet set) {
  switch (set) {
    case InstructionSet::portable:
      return true;
#ifdef __x86_64__
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
    if (set <= widest_allowed && is_supported(set)) return set;
  return InstructionSet::portable;
}

void use_at_most(InstructionSet set) {
  widest_allowed = set;
  // of large products Eigen sums blocks that are as large as the processor's caches: not as any of them, but always so
  constexpr std::ptrdiff_t l1 = 32 << 10, l2 = 256 << 10, l3 = 2 << 20;  // [bytes]
  Eigen::setCpuCacheSizes(l1, l2, l3);
}

const char* name_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx2:
      return "avx2";
    case InstructionSet::avx512:
      return "avx512";
    default:
      return "portable";
  }
}

}  // namespace umax
