// The kernels of core/linear/direct/front_kernel.h. Columns are taken six at a time, as nodes have three unknowns each and
// twelve to twenty-four vectors of sums fill the registers; each tile of rows x columns stays in registers from its first
// product to its division.
#pragma once

#include <cmath>

#include "core/base/simd.h"
#include "core/linear/direct/front_kernel.h"

namespace umax::UMAX_SIMD {

inline constexpr int lanes = width<double>;
inline constexpr int most_vectors = UMAX_SIMD_BYTES == 64 ? 4 : 2;  // of rows in a tile
inline constexpr int most_columns = 6;                              // of a tile

/// The factor of a tile's square on the diagonal, by columns.
struct Corner {
  double values[most_columns][most_columns + lanes];
  double inverse[most_columns];  // of the diagonal
};

// sums = the tile minus the products of its rows with those of its columns, over [first, first + count)
template <int R, int C>
UMAX_INLINE void accumulate(const Front& front, int row, int column, int first, int count, Vec<double> (&sums)[C][R]) {
  for (int c = 0; c < C; ++c)
    for (int r = 0; r < R; ++r)
      sums[c][r] = load<double>(front.values + std::size_t(column + c) * front.stride + row + r * lanes);
  const double* at = front.values + std::size_t(first) * front.stride;
  for (int k = 0; k < count; ++k, at += front.stride) {
    Vec<double> rows[R];
    for (int r = 0; r < R; ++r) rows[r] = load<double>(at + row + r * lanes);
    for (int c = 0; c < C; ++c) {
      const Vec<double> factor = broadcast(at[column + c]);
      for (int r = 0; r < R; ++r) sums[c][r] = multiply_subtract(rows[r], factor, sums[c][r]);
    }
  }
}

template <int R, int C, bool divides>
UMAX_INLINE void tile(const Front& front, int row, int column, int first, int count, const Corner* corner) {
  Vec<double> sums[C][R];
  accumulate<R, C>(front, row, column, first, count, sums);
  if constexpr (divides)
    for (int c = 0; c < C; ++c) {
      for (int d = 0; d < c; ++d) {
        const Vec<double> factor = broadcast(corner->values[d][c]);
        for (int r = 0; r < R; ++r) sums[c][r] = multiply_subtract(sums[d][r], factor, sums[c][r]);
      }
      const Vec<double> inverse = broadcast(corner->inverse[c]);
      for (int r = 0; r < R; ++r) sums[c][r] *= inverse;
    }
  for (int c = 0; c < C; ++c)
    for (int r = 0; r < R; ++r)
      store<double>(front.values + std::size_t(column + c) * front.stride + row + r * lanes, sums[c][r]);
}

// rows [row, size) of C columns
template <int C, bool divides>
UMAX_INLINE void tiles(const Front& front, int row, int column, int first, int count, const Corner* corner = nullptr) {
  for (; row + (most_vectors - 1) * lanes < front.size; row += most_vectors * lanes)
    tile<most_vectors, C, divides>(front, row, column, first, count, corner);
  for (; row < front.size; row += lanes) tile<1, C, divides>(front, row, column, first, count, corner);
}

// Cholesky factorisation of the square on the diagonal, into the corner and the front
template <int C>
UMAX_INLINE bool factorize_corner(const Front& front, int column, int first, int count, Corner& corner) {
  constexpr int R = (C + lanes - 1) / lanes;
  Vec<double> sums[C][R];
  accumulate<R, C>(front, column, column, first, count, sums);
  for (int c = 0; c < C; ++c)
    for (int r = 0; r < R; ++r) store<double>(corner.values[c] + r * lanes, sums[c][r]);
  for (int c = 0; c < C; ++c) {
    double* const own = corner.values[c];
    if (!(own[c] > 0)) return false;
    own[c] = std::sqrt(own[c]);
    corner.inverse[c] = 1 / own[c];
    for (int i = c + 1; i < C; ++i) own[i] *= corner.inverse[c];
    for (int d = c + 1; d < C; ++d)
      for (int i = d; i < C; ++i) corner.values[d][i] -= own[i] * own[d];
    double* const to = front.values + std::size_t(column + c) * front.stride + column;
    for (int i = c; i < C; ++i) to[i] = own[i];
  }
  return true;
}

template <int C>
UMAX_INLINE bool eliminate_columns(const Front& front, int column, int first, int count) {
  Corner corner;
  if (!factorize_corner<C>(front, column, first, count, corner)) return false;
  tiles<C, true>(front, column + C, column, first, count, &corner);
  return true;
}

inline bool eliminate(const Front& front, int first, int count) {
  const int end = first + count;
  int column = first;
  for (; column + most_columns <= end; column += most_columns)
    if (!eliminate_columns<most_columns>(front, column, first, column - first)) return false;
  for (; column + 3 <= end; column += 3)
    if (!eliminate_columns<3>(front, column, first, column - first)) return false;
  for (; column < end; ++column)
    if (!eliminate_columns<1>(front, column, first, column - first)) return false;
  return true;
}

inline void update(const Front& front, int first, int count, int begin, int end) {
  int column = begin;
  for (; column + most_columns <= end; column += most_columns)
    tiles<most_columns, false>(front, column, column, first, count);
  for (; column + 3 <= end; column += 3) tiles<3, false>(front, column, column, first, count);
  for (; column < end; ++column) tiles<1, false>(front, column, column, first, count);
}

inline constexpr FrontKernels front_kernels{&eliminate, &update};

}  // namespace umax::UMAX_SIMD

namespace umax {

// NOLINTBEGIN(misc-definitions-in-headers): included once for each instruction set
template <>
const FrontKernels& kernels_for<FrontKernels, InstructionSet::UMAX_SIMD>() {
  return UMAX_SIMD::front_kernels;
}
// NOLINTEND(misc-definitions-in-headers)

}  // namespace umax
