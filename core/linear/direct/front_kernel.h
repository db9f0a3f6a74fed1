// Dense partial Cholesky factorisation of small symmetric matrices ("fronts"), compiled once for each instruction set and
// chosen at run time. A BLAS spends more time on getting ready than on matrices of a hundred rows: its potrf and trsm took
// 60 % of the factorisation of 365 hexes.
#pragma once

#include <cstddef>

#include "core/base/instruction_set.h"

namespace umax {

/// Columns that are eliminated before what is behind them is brought up to date.
inline constexpr int front_panel = 96;

/// A front: size x size by columns, its lower triangle in use. Kernels write zeros to what is beyond its last row.
struct Front {
  double* values = nullptr;
  std::size_t stride = 0;  // at least front_stride(size)
  int size = 0;
};

struct FrontKernels {
  /// Overwrites columns [first, first + count) of what is left of the front by those of its Cholesky factor. False if they
  /// are not positive definite.
  bool (*eliminate)(const Front& front, int first, int count);

  /// Takes L L^T of these eliminated columns from columns [begin, end) behind them.
  void (*update)(const Front& front, int first, int count, int begin, int end);
};

const FrontKernels& front_kernels(InstructionSet set);

/// Doubles from column to column: room for vectors that reach beyond the last row, and no power of two, whose columns
/// would share a few lines of the cache.
inline std::size_t front_stride(int size) {
  constexpr std::size_t most_lanes = 8;
  return ((std::size_t(size) + 2 * most_lanes - 1) / most_lanes | 1) * most_lanes;
}

}  // namespace umax
