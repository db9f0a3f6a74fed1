// The one source of the kernels: hex_kernel_<instruction set>.cpp includes it under its own compiler options.
#pragma once

#include "core/hex_kernel.h"
#include "core/simd.h"

namespace umax::UMAX_SIMD {

inline constexpr int rows = brick_edge + 1;    // of cells that touch a brick's nodes, along x and y
inline constexpr int planes = brick_edge + 2;  // of nodes that those cells touch
inline constexpr int half_modes = 12;          // (b, c) modes of a pair of node lines, by component: 3 (2 b + c) + axis

/// What a task keeps between rows of cells.
template <class T>
struct Tile {
  Vec<T> plane_modes[rows][half_modes];   // of the node plane before, by row of cells
  Vec<T> upper_forces[rows][half_modes];  // that the cells of the plane before give to this one
  Vec<T> above[brick_lines][3];           // that the vector of cells below gives to this one
  const T* lines[planes][planes];         // node lines around the brick
  const T* next_lines[planes][planes];    // the same in the bricks above
  const void* frames[rows][rows];         // cell lines that touch the brick's nodes; null: no cells
};

// place of a line of the halo: which brick along the axis, and its index there
UMAX_INLINE int brick_step(int index) {
  return index < 0 ? -1 : index >= brick_edge ? 1 : 0;
}

template <class T, class S>
void find_lines(const Sweep<T, S>& sweep, const Brick& brick, Tile<T>& tile) {
  for (int p = -1; p <= brick_edge; ++p)
    for (int j = -1; j <= brick_edge; ++j) {
      const int di = brick_step(p), dj = brick_step(j);
      const int line = brick_edge * (p & (brick_edge - 1)) + (j & (brick_edge - 1));
      const int here = brick.near[near_index(di, dj, 0)], next = brick.near[near_index(di, dj, 1)];
      tile.lines[p + 1][j + 1] = sweep.x + line_offset(here, line, vector_components);
      tile.next_lines[p + 1][j + 1] = sweep.x + line_offset(next, line, vector_components);
      if (p == brick_edge || j == brick_edge) continue;
      const bool has_cells = sweep.bricks[here].cell_lines >> line & 1;
      tile.frames[p + 1][j + 1] = has_cells ? sweep.frames + line_offset(here, line, frame_components) : nullptr;
    }
}

// sum and difference along z of a node line: s[0 .. 2], s[3 .. 5]
template <class T>
UMAX_INLINE void transform_line(const Tile<T>& tile, int p, int j, int v, Vec<T>* s) {
  const bool last = (v + 1) * width<T> == brick_lanes;
  const T* line = tile.lines[p][j] + v * width<T>;
  const T* next = last ? tile.next_lines[p][j] : line + width<T>;
  for (int c = 0; c < 3; ++c) {
    const Vec<T> x = load<T>(line + c * brick_lanes);
    const Vec<T> x1 = shift_down(x, load<T>(next + c * brick_lanes));
    s[c] = x1 + x;
    s[3 + c] = x1 - x;
  }
}

template <class V>
struct Frame {
  V q[9];
  UMAX_INLINE void to_local(V* u) const {
    V r[3];
    for (int c = 0; c < 3; ++c) r[c] = multiply_add(q[6 + c], u[2], multiply_add(q[3 + c], u[1], q[c] * u[0]));
    for (int c = 0; c < 3; ++c) u[c] = r[c];
  }
  UMAX_INLINE void to_world(V* u) const {
    V r[3];
    for (int c = 0; c < 3; ++c)
      r[c] = multiply_add(q[3 * c + 2], u[2], multiply_add(q[3 * c + 1], u[1], q[3 * c] * u[0]));
    for (int c = 0; c < 3; ++c) u[c] = r[c];
  }
};

template <class V, class T>
UMAX_INLINE void multiply_pair(const T* k, V& a, V& b) {
  const V first = multiply_add(V{} + k[1], b, (V{} + k[0]) * a);
  b = multiply_add(V{} + k[2], b, (V{} + k[1]) * a);
  a = first;
}

template <class V, class T>
UMAX_INLINE void multiply_triple(const T* k, V& a, V& b, V& c) {
  const V first = multiply_add(V{} + k[2], c, multiply_add(V{} + k[1], b, (V{} + k[0]) * a));
  const V second = multiply_add(V{} + k[4], c, multiply_add(V{} + k[3], b, (V{} + k[1]) * a));
  c = multiply_add(V{} + k[5], c, multiply_add(V{} + k[4], b, (V{} + k[2]) * a));
  a = first;
  b = second;
}

// modes of 3 components each: rotate, multiply, rotate back
template <class V, class T>
UMAX_INLINE void linear_forces(const HexConstants<T>& k, const Frame<V>& frame, V* x, V* y, V* z) {
  frame.to_local(x), frame.to_local(y), frame.to_local(z);
  multiply_triple(k.normal, x[0], y[1], z[2]);
  multiply_pair(k.shear[0], x[1], y[0]);
  multiply_pair(k.shear[1], x[2], z[0]);
  multiply_pair(k.shear[2], y[2], z[1]);
  frame.to_world(x), frame.to_world(y), frame.to_world(z);
}

template <class V, class T>
UMAX_INLINE void bilinear_forces(const HexConstants<T>& k, const Frame<V>& frame, V* xy, V* xz, V* yz) {
  frame.to_local(xy), frame.to_local(xz), frame.to_local(yz);
  multiply_pair(k.bend[0], xy[1], xz[2]);
  multiply_pair(k.bend[1], xy[0], yz[2]);
  multiply_pair(k.bend[2], xz[0], yz[1]);
  multiply_triple(k.twist, yz[0], xz[1], xy[2]);
  frame.to_world(xy), frame.to_world(xz), frame.to_world(yz);
}

template <class V, class T>
UMAX_INLINE void trilinear_forces(const HexConstants<T>& k, const Frame<V>& frame, V* xyz) {
  frame.to_local(xyz);
  for (int c = 0; c < 3; ++c) xyz[c] *= k.trilinear[c];
  frame.to_world(xyz);
}

// forces of a vector of cells from the half-transformed node planes on both sides: `lower` is added to what the lower
// plane has, `upper` becomes what the upper plane gets
template <class T, class S>
UMAX_INLINE void cell_forces(const HexConstants<T>& k, const S* frames, const Vec<T>* before, const Vec<T>* after,
                             Vec<T>* lower, Vec<T>* upper) {
  using V = Vec<T>;
  Frame<V> frame;
  for (int r = 0; r < 9; ++r) frame.q[r] = load<T>(frames + r * brick_lanes);
  V x[3], y[3], z[3];
  for (int c = 0; c < 3; ++c) {
    x[c] = after[c] - before[c];
    z[c] = after[3 + c] + before[3 + c];
    y[c] = after[6 + c] + before[6 + c];
  }
  linear_forces(k, frame, x, y, z);
  V xz[3], xy[3], yz[3], xyz[3];
  for (int c = 0; c < 3; ++c) {
    xz[c] = after[3 + c] - before[3 + c];
    xy[c] = after[6 + c] - before[6 + c];
    yz[c] = after[9 + c] + before[9 + c];
    xyz[c] = after[9 + c] - before[9 + c];
  }
  bilinear_forces(k, frame, xy, xz, yz);
  trilinear_forces(k, frame, xyz);
  for (int c = 0; c < 3; ++c) {
    lower[c] = upper[c] - x[c];
    upper[c] = x[c];
    lower[3 + c] = upper[3 + c] + (z[c] - xz[c]);
    upper[3 + c] = z[c] + xz[c];
    lower[6 + c] = upper[6 + c] + (y[c] - xy[c]);
    upper[6 + c] = y[c] + xy[c];
    lower[9 + c] = upper[9 + c] + (yz[c] - xyz[c]);
    upper[9 + c] = yz[c] + xyz[c];
  }
}

template <class T, class S, Epilogue E>
UMAX_INLINE void finish(const Sweep<T, S>& sweep, std::size_t slot, int lane, Vec<T>* y, Vec<T>& sum) {
  using V = Vec<T>;
  const std::size_t at = vector_components * slot + lane;
  const V w = load<T>(sweep.diagonal + slot + lane);
  V x[3];
  for (int c = 0; c < 3; ++c) {
    x[c] = load<T>(sweep.x + at + c * brick_lanes);
    y[c] = multiply_add(w, x[c], y[c]);
  }
  if constexpr (E == Epilogue::apply) {
    for (int c = 0; c < 3; ++c) {
      y[c] = where_positive<T>(w, y[c]);
      sum = multiply_add(x[c], y[c], sum);
      store<T>(static_cast<T*>(sweep.out) + at + c * brick_lanes, y[c]);
    }
  } else if constexpr (E == Epilogue::residual) {
    for (int c = 0; c < 3; ++c) {
      const V r = where_positive<T>(w, load<T>(sweep.b + at + c * brick_lanes) - y[c]);
      sum = multiply_add(r, r, sum);
      store<T>(static_cast<float*>(sweep.out) + at + c * brick_lanes, r);
    }
  } else {
    const float* inverse = sweep.inverse + inverse_components * slot + lane;
    V d[6], r[3], b[3];
    for (int q = 0; q < 6; ++q) d[q] = load<T>(inverse + q * brick_lanes);
    for (int c = 0; c < 3; ++c) {
      b[c] = load<T>(sweep.b + at + c * brick_lanes);
      r[c] = (b[c] - y[c]) * sweep.gain;
    }
    const V z[3] = {multiply_add(d[2], r[2], multiply_add(d[1], r[1], d[0] * r[0])),
                    multiply_add(d[4], r[2], multiply_add(d[3], r[1], d[1] * r[0])),
                    multiply_add(d[5], r[2], multiply_add(d[4], r[1], d[2] * r[0]))};
    T* out = static_cast<T*>(sweep.out) + at;
    for (int c = 0; c < 3; ++c) {
      V next = multiply_add(V{} + sweep.keep, x[c], z[c]);
      if (sweep.momentum != 0) next = multiply_add(V{} + sweep.momentum, load<T>(out + c * brick_lanes), next);
      sum = multiply_add(b[c], next, sum);
      store<T>(out + c * brick_lanes, next);
    }
  }
}

// one vector of cells along z for all rows of two node planes: completes the lower plane where it is the brick's own
template <class T, class S, Epilogue E>
UMAX_INLINE void sweep_plane(const Sweep<T, S>& sweep, const Brick& brick, int index, int p, int v, Tile<T>& tile,
                             Vec<T>& sum) {
  using V = Vec<T>;
  const int i = p - 1;  // own node plane that the cells complete
  V left[6], carried[6] = {};
  transform_line(tile, p + 1, 0, v, left);
  for (int row = 0; row < rows; ++row) {
    V right[6], after[half_modes], lower[half_modes];
    transform_line(tile, p + 1, row + 1, v, right);
    for (int c = 0; c < 6; ++c) {
      after[c] = right[c] + left[c];
      after[6 + c] = right[c] - left[c];
      left[c] = right[c];
    }
    V* before = tile.plane_modes[row];
    if (p >= 0) {
      V* upper = tile.upper_forces[row];
      const S* frames = static_cast<const S*>(tile.frames[p][row]);
      if (frames) {
        cell_forces<T, S>(*sweep.constants, frames + v * width<T>, before, after, lower, upper);
      } else {
        for (int m = 0; m < half_modes; ++m) lower[m] = upper[m], upper[m] = V{};
      }
      if (i >= 0) {
        const int line = brick_edge * i + row - 1;
        if (row > 0 && (brick.node_lines >> line & 1)) {
          V y[3];
          for (int c = 0; c < 3; ++c) {
            const V h0 = carried[c] + (lower[c] - lower[6 + c]), h1 = carried[3 + c] + (lower[3 + c] - lower[9 + c]);
            const V up = h0 + h1;
            y[c] = (h0 - h1) + shift_up(tile.above[line][c], up);
            tile.above[line][c] = up;
          }
          finish<T, S, E>(sweep, line_offset(index, line, 1), v * width<T>, y, sum);
        }
        for (int c = 0; c < 6; ++c) carried[c] = lower[c] + lower[6 + c];
      }
    }
    for (int m = 0; m < half_modes; ++m) before[m] = after[m];
  }
}

template <class T, class S, Epilogue E>
double sweep_bricks(const Sweep<T, S>& sweep, int first, int last) {
  Tile<T> tile;
  double total = 0;
  for (int index = first; index < last; ++index) {
    const Brick& brick = sweep.bricks[index];
    if (!brick.continues) __builtin_memset(tile.above, 0, sizeof(tile.above));
    find_lines(sweep, brick, tile);
    for (int v = 0; v < brick_lanes / width<T>; ++v) {
      Vec<T> sum{};
      __builtin_memset(tile.upper_forces, 0, sizeof(tile.upper_forces));
      for (int p = -1; p <= brick_edge; ++p) sweep_plane<T, S, E>(sweep, brick, index, p, v, tile, sum);
      total += sum_of_lanes<T>(sum);
    }
  }
  return total;
}

template <class T, class S>
constexpr void fill(SweepFunction<T, S>* table) {
  table[int(Epilogue::apply)] = sweep_bricks<T, S, Epilogue::apply>;
  table[int(Epilogue::residual)] = sweep_bricks<T, S, Epilogue::residual>;
  table[int(Epilogue::chebyshev)] = sweep_bricks<T, S, Epilogue::chebyshev>;
}

constexpr HexKernels make_kernels() {
  HexKernels kernels;
  fill<float, float>(kernels.float_sweeps);
  fill<double, float>(kernels.mixed_sweeps);
  fill<double, double>(kernels.double_sweeps);
  return kernels;
}

extern const HexKernels kernels;
constexpr HexKernels kernels = make_kernels();

}  // namespace umax::UMAX_SIMD
