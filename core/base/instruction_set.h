// The instruction sets that kernels are compiled for, and which of them this process uses.
#pragma once

namespace umax {

enum class InstructionSet { portable, avx2, avx512 };

/// Can this machine run it? The portable one always can.
bool is_supported(InstructionSet set);

/// The widest that is supported and not beyond use_at_most().
InstructionSet best_instruction_set();

/// From now on none that is wider: results of wider ones have other last bits. For the start of a program.
void use_at_most(InstructionSet set);

/// "avx2"
const char* name_of(InstructionSet set);

/// The table of kernels that is compiled for this instruction set. The kernels' own source specialises it; callers choose by
/// core/base/kernel_choice.h.
template <class Table, InstructionSet set>
const Table& kernels_for();

}  // namespace umax
