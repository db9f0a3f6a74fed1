// Compiled once for each instruction set, as the library's kernels are.
#pragma once

#include "core/linear/bricks/hex_kernel_body.h"
#include "tests/support/double_kernels.h"

namespace umax::UMAX_SIMD {

extern const test::DoubleKernels double_kernels;
constexpr test::DoubleKernels double_kernels = {
    sweep_runs<double, float, Epilogue::apply>, sweep_runs<double, float, Epilogue::residual>,
    sweep_runs<double, double, Epilogue::apply>, sweep_runs<double, double, Epilogue::residual>};

}  // namespace umax::UMAX_SIMD
