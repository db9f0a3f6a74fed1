// The sweeps of the matrix-free operator in double; one table for each instruction set.
#pragma once

#include "core/linear/bricks/hex_kernel.h"

namespace umax::test {

struct DoubleKernels {
  SweepFunction<double, float> mixed_apply, mixed_residual;  // the matrix stored as float
  SweepFunction<double, double> apply, residual;
};

}  // namespace umax::test
