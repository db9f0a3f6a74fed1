// Choosing among the tables of kernels that are compiled for several instruction sets. For the files that
// umax_kernel_options() in CMake names, which have UMAX_X86_KERNELS where there are more tables than the portable one.
#pragma once

#include "core/base/instruction_set.h"

namespace umax {

template <class Table>
const Table& chosen_kernels([[maybe_unused]] InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return kernels_for<Table, InstructionSet::avx512>();
  if (set == InstructionSet::avx2) return kernels_for<Table, InstructionSet::avx2>();
#endif
  return kernels_for<Table, InstructionSet::portable>();
}

}  // namespace umax
