// Compiled once for each instruction set, as the library's kernels are.
#pragma once

#include "core/linear/bricks/hex_kernel_body.h"
#include "tests/support/double_kernels.h"

namespace umax::UMAX_SIMD {

inline constexpr test::DoubleKernels double_kernels = {
    sweep_runs<double, float, Epilogue::apply>, sweep_runs<double, float, Epilogue::residual>,
    sweep_runs<double, double, Epilogue::apply>, sweep_runs<double, double, Epilogue::residual>};

}  // namespace umax::UMAX_SIMD

namespace umax {

// NOLINTBEGIN(misc-definitions-in-headers): included once for each instruction set
template <>
const test::DoubleKernels& kernels_for<test::DoubleKernels, InstructionSet::UMAX_SIMD>() {
  return UMAX_SIMD::double_kernels;
}
// NOLINTEND(misc-definitions-in-headers)

}  // namespace umax
