// The one source of the kernels: hex_kernel_<instruction set>.cpp includes it under its own compiler options.
#pragma once

#include "core/hex_kernel.h"
#include "core/simd.h"

namespace umax::UMAX_SIMD {

inline constexpr int rows = brick_edge + 1;    // of cells that touch a brick's nodes, along x and y
inline constexpr int planes = brick_edge + 2;  // of nodes that those cells touch

/// What a task keeps between rows of cells. Its address must not leave the inlined functions: the compiler would have
/// to suspect every store of changing it.
template <class T>
struct Tile {
  Vec<T> plane_modes[2][rows][4][3];  // of the node planes before and after the cells, by row of cells
  Vec<T> upper_forces[rows][4][3];    // that the cells of the plane before give to this one
  Vec<T> above[brick_lines][3];       // that the vector of cells below gives to this one
};

/// Where the lines around a brick begin.
template <class T, class S>
struct Lines {
  const T* nodes[planes][planes];
  const T* next_nodes[planes][planes];  // in the bricks above
  const S* frames[rows][rows];          // null: no cells
};

// place of a line of the halo: which brick along the axis, and its index there
UMAX_INLINE int brick_step(int index) {
  return index < 0 ? -1 : index >= brick_edge ? 1 : 0;
}

template <class T, class S>
void find_lines(const Sweep<T, S>& sweep, const Brick& brick, Lines<T, S>& lines) {
  for (int p = -1; p <= brick_edge; ++p)
    for (int j = -1; j <= brick_edge; ++j) {
      const int di = brick_step(p), dj = brick_step(j);
      const int line = brick_edge * (p & (brick_edge - 1)) + (j & (brick_edge - 1));
      const int here = brick.near[near_index(di, dj, 0)], next = brick.near[near_index(di, dj, 1)];
      lines.nodes[p + 1][j + 1] = sweep.x + line_offset(here, line, vector_components);
      lines.next_nodes[p + 1][j + 1] = sweep.x + line_offset(next, line, vector_components);
      if (p == brick_edge || j == brick_edge) continue;
      const bool has_cells = sweep.bricks[here].cell_lines >> line & 1;
      lines.frames[p + 1][j + 1] = has_cells ? sweep.frames + line_offset(here, line, frame_components) : nullptr;
    }
}

// what a task has in registers' width from the start: the constants in every lane
template <class T>
struct Lanes {
  HexConstants<Vec<T>> hex;
  Vec<T> keep, momentum, gain;
  Vec<T> rest[3];
};

template <class T, class S>
UMAX_INLINE Lanes<T> broadcast_all(const Sweep<T, S>& sweep) {
  constexpr int count = int(sizeof(HexConstants<T>) / sizeof(T));
  Lanes<T> lanes;
  Vec<T> all[count];
  T values[count];
  __builtin_memcpy(values, sweep.constants, sizeof(values));
  for (int i = 0; i < count; ++i) all[i] = broadcast<T>(values[i]);
  __builtin_memcpy(&lanes.hex, all, sizeof(all));
  lanes.keep = broadcast<T>(sweep.keep);
  lanes.momentum = broadcast<T>(sweep.momentum);
  lanes.gain = broadcast<T>(sweep.gain);
  for (int axis = 0; axis < 3; ++axis) lanes.rest[axis] = broadcast<T>(sweep.rest[axis]);
  return lanes;
}

// sum and difference along z of a node line: s[0 .. 2], s[3 .. 5]
template <class T, class S>
UMAX_INLINE void transform_line(const Lines<T, S>& lines, int p, int j, int v, Vec<T> (&s)[2][3]) {
  const bool last = (v + 1) * width<T> == brick_lanes;
  const T* line = lines.nodes[p][j] + v * width<T>;
  const T* next = last ? lines.next_nodes[p][j] : line + width<T>;
  for (int c = 0; c < 3; ++c) {
    const Vec<T> x = load<T>(line + c * brick_lanes);
    const Vec<T> x1 = shift_down(x, load<T>(next + c * brick_lanes));
    s[0][c] = x1 + x;
    s[1][c] = x1 - x;
  }
}

// sqrt(s) R of a vector of cells
template <class V>
struct Frame {
  V q[9];
  // all of it stays in registers up to here
  UMAX_INLINE void keep() {
    asm volatile(""
                 : "+x"(q[0]), "+x"(q[1]), "+x"(q[2]), "+x"(q[3]), "+x"(q[4]), "+x"(q[5]), "+x"(q[6]), "+x"(q[7]),
                   "+x"(q[8]));
  }
  // R^T u
  UMAX_INLINE void to_local(const V* u, V* r) const {
    for (int c = 0; c < 3; ++c) r[c] = multiply_add(q[6 + c], u[2], multiply_add(q[3 + c], u[1], q[c] * u[0]));
  }
  // R u
  UMAX_INLINE void to_world(const V* u, V* r) const {
    for (int c = 0; c < 3; ++c)
      r[c] = multiply_add(q[3 * c + 2], u[2], multiply_add(q[3 * c + 1], u[1], q[3 * c] * u[0]));
  }
  // r + R u
  UMAX_INLINE void add_to_world(const V* u, V* r) const {
    for (int c = 0; c < 3; ++c)
      r[c] = multiply_add(q[3 * c + 2], u[2], multiply_add(q[3 * c + 1], u[1], multiply_add(q[3 * c], u[0], r[c])));
  }
};

template <class T, class S>
UMAX_INLINE Frame<Vec<T>> load_frame(const S* frames) {
  Frame<Vec<T>> frame;
  for (int r = 0; r < 9; ++r) frame.q[r] = load<T>(frames + r * brick_lanes);
  return frame;
}

// Values computed so far go to memory: 16 registers hold a frame or a group of modes, not both, and left to itself the
// compiler mixes the stages and spills.
template <class A>
UMAX_INLINE void end_of_stage(A& values) {
  asm volatile("" : "+m"(values));
}

template <class V>
UMAX_INLINE void multiply_pair(const V* k, V& a, V& b) {
  const V first = multiply_add(k[1], b, k[0] * a);
  b = multiply_add(k[2], b, k[1] * a);
  a = first;
}

template <class V>
UMAX_INLINE void multiply_triple(const V* k, V& a, V& b, V& c) {
  const V first = multiply_add(k[2], c, multiply_add(k[1], b, k[0] * a));
  const V second = multiply_add(k[4], c, multiply_add(k[3], b, k[1] * a));
  c = multiply_add(k[5], c, multiply_add(k[4], b, k[2] * a));
  a = first;
  b = second;
}

// modes of a cell by number (x 4, y 2, z 1), 3 components each, in their own frame: K u
template <class V>
UMAX_INLINE void multiply_stiffness(const HexConstants<V>& k, V (*m)[3]) {
  constexpr int x = 4, y = 2, z = 1, xy = 6, xz = 5, yz = 3, xyz = 7;
  multiply_triple(k.normal, m[x][0], m[y][1], m[z][2]);
  multiply_pair(k.shear[0], m[x][1], m[y][0]);
  multiply_pair(k.shear[1], m[x][2], m[z][0]);
  multiply_pair(k.shear[2], m[y][2], m[z][1]);
  multiply_pair(k.bend[0], m[xy][1], m[xz][2]);
  multiply_pair(k.bend[1], m[xy][0], m[yz][2]);
  multiply_pair(k.bend[2], m[xz][0], m[yz][1]);
  multiply_triple(k.twist, m[yz][0], m[xz][1], m[xy][2]);
  for (int c = 0; c < 3; ++c) m[xyz][c] *= k.trilinear[c];
}

// along y: the four halves of a row from its two lines; `left` moves on to the right
template <class V>
UMAX_INLINE void transform_row(const V (&right)[2][3], V (&left)[2][3], V (&after)[4][3]) {
  for (int part = 0; part < 2; ++part)
    for (int c = 0; c < 3; ++c) {
      after[part][c] = right[part][c] + left[part][c];
      after[2 + part][c] = right[part][c] - left[part][c];
      left[part][c] = right[part][c];
    }
}

// along x, then into the cells' frames: modes `half` and 4 + half
template <class V>
UMAX_INLINE void transform_cells(Frame<V>& frame, const V* after, const V* before, int half, V (&modes)[8][3]) {
  V u[3];
  for (int c = 0; c < 3; ++c) u[c] = after[c] - before[c];
  frame.keep();
  frame.to_local(u, modes[4 + half]);
  end_of_stage(modes[4 + half]);
  if (half == 0) return;
  for (int c = 0; c < 3; ++c) u[c] = after[c] + before[c];
  frame.keep();
  frame.to_local(u, modes[half]);
  end_of_stage(modes[half]);
}

// from positions to displacements: less what the hex at rest has, times the frame's length sqrt(s)
template <class T, class S>
UMAX_INLINE void subtract_rest(const Lanes<T>& lanes, const S* frames, Vec<T> (&modes)[8][3]) {
  Vec<T> squared{};
  for (int r = 0; r < 9; ++r) {
    const Vec<T> q = load<T>(frames + r * brick_lanes);
    squared = multiply_add(q, q, squared);
  }
  const Vec<T> root = square_root<T>(squared / 3);
  modes[4][0] -= root * lanes.rest[0];
  modes[2][1] -= root * lanes.rest[1];
  modes[1][2] -= root * lanes.rest[2];
}

// forces in modes `half` and 4 + half back to the planes: `lower` becomes what the lower one has so far with these
// cells, `upper` what the upper one gets
template <class V>
UMAX_INLINE void spread_to_planes(Frame<V>& frame, const V (&modes)[8][3], int half, V* upper, V* lower) {
  frame.keep();
  if (half == 0) {
    V f[3];
    frame.to_world(modes[4], f);
    for (int c = 0; c < 3; ++c) {
      lower[c] = upper[c] - f[c];
      upper[c] = f[c];
    }
    return;
  }
  V u[3];
  for (int c = 0; c < 3; ++c) {
    u[c] = modes[half][c] - modes[4 + half][c];
    lower[c] = upper[c];
  }
  frame.add_to_world(u, lower);
  frame.keep();
  for (int c = 0; c < 3; ++c) u[c] = modes[half][c] + modes[4 + half][c];
  frame.to_world(u, upper);
}

template <class T, class S, Epilogue E>
UMAX_INLINE void finish(const Sweep<T, S>& sweep, const Lanes<T>& lanes, std::size_t slot, int lane, Vec<T>* y,
                        Vec<T>& sum) {
  using V = Vec<T>;
  const std::size_t at = vector_components * slot + lane;
  const V w = load<T>(sweep.diagonal + slot + lane);
  if constexpr (E == Epilogue::force) {
    for (int c = 0; c < 3; ++c) {
      const V f = load<T>(sweep.b + at + c * brick_lanes) - y[c];
      store<T>(static_cast<T*>(sweep.out) + at + c * brick_lanes, where_positive<T>(w, f));
    }
    return;
  }
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
      r[c] = (b[c] - y[c]) * lanes.gain;
    }
    const V z[3] = {multiply_add(d[2], r[2], multiply_add(d[1], r[1], d[0] * r[0])),
                    multiply_add(d[4], r[2], multiply_add(d[3], r[1], d[1] * r[0])),
                    multiply_add(d[5], r[2], multiply_add(d[4], r[1], d[2] * r[0]))};
    T* out = static_cast<T*>(sweep.out) + at;
    for (int c = 0; c < 3; ++c) {
      V next = multiply_add(lanes.keep, x[c], z[c]);
      if (sweep.momentum != 0) next = multiply_add(lanes.momentum, load<T>(out + c * brick_lanes), next);
      sum = multiply_add(b[c], next, sum);
      store<T>(out + c * brick_lanes, next);
    }
  }
}

// one vector of cells along z for all rows of two node planes: completes the lower plane where it is the brick's own
template <class T, class S, Epilogue E>
UMAX_INLINE void sweep_plane(const Sweep<T, S>& sweep, const Lanes<T>& lanes, const Brick& brick,
                             const Lines<T, S>& lines, int index, int p, int v, Tile<T>& tile, Vec<T>& sum) {
  using V = Vec<T>;
  V left[2][3], carried[2][3];
  for (int c = 0; c < 3; ++c) carried[0][c] = carried[1][c] = V{};
  transform_line(lines, p + 1, 0, v, left);
  for (int row = 0; row < rows; ++row) {
    V right[2][3], modes[8][3], low[2][3], h[2][3];
    const V(&before)[4][3] = tile.plane_modes[~p & 1][row];
    V(&after)[4][3] = tile.plane_modes[p & 1][row];
    V(&upper)[4][3] = tile.upper_forces[row];
    transform_line(lines, p + 1, row + 1, v, right);
    transform_row(right, left, after);
    end_of_stage(left);
    end_of_stage(after);
    if (p < 0) continue;

    if (const S* frames = lines.frames[p][row]) {
      {
        Frame<V> frame = load_frame<T>(frames + v * width<T>);
#pragma GCC unroll 4
        for (int half = 0; half < 4; ++half) transform_cells(frame, after[half], before[half], half, modes);
      }
      if constexpr (E == Epilogue::force) subtract_rest<T>(lanes, frames + v * width<T>, modes);
      multiply_stiffness(lanes.hex, modes);
      end_of_stage(modes);
      Frame<V> frame = load_frame<T>(frames + v * width<T>);
#pragma GCC unroll 2
      for (int part = 0; part < 2; ++part) {
        V high[3];
        spread_to_planes(frame, modes, part, upper[part], low[part]);
        end_of_stage(low[part]);
        spread_to_planes(frame, modes, 2 + part, upper[2 + part], high);
        for (int c = 0; c < 3; ++c) {
          h[part][c] = carried[part][c] + (low[part][c] - high[c]);
          carried[part][c] = low[part][c] + high[c];
        }
        end_of_stage(carried[part]);
        end_of_stage(h[part]);
      }
    } else {
      for (int part = 0; part < 2; ++part)
        for (int c = 0; c < 3; ++c) {
          h[part][c] = carried[part][c] + (upper[part][c] - upper[2 + part][c]);
          carried[part][c] = upper[part][c] + upper[2 + part][c];
          upper[part][c] = upper[2 + part][c] = V{};
        }
    }

    // back along z, at the brick's own nodes
    const int line = brick_edge * (p - 1) + row - 1;
    if (p == 0 || row == 0 || !(brick.node_lines >> line & 1)) continue;
    V y[3];
    for (int c = 0; c < 3; ++c) {
      const V up = h[0][c] + h[1][c];
      y[c] = (h[0][c] - h[1][c]) + shift_up(tile.above[line][c], up);
      tile.above[line][c] = up;
    }
    finish<T, S, E>(sweep, lanes, line_offset(index, line, 1), v * width<T>, y, sum);
  }
}

template <class T, class S, Epilogue E>
double sweep_bricks(const Sweep<T, S>& sweep, int first, int last) {
  using V = Vec<T>;
  const Lanes<T> lanes = broadcast_all(sweep);
  Tile<T> tile;
  Lines<T, S> lines;
  double total = 0;
  for (int index = first; index < last; ++index) {
    const Brick& brick = sweep.bricks[index];
    if (!brick.continues)
      for (auto& line : tile.above)
        for (V& value : line) value = V{};
    find_lines(sweep, brick, lines);
    for (int v = 0; v < brick_lanes / width<T>; ++v) {
      Vec<T> sum{};
      for (auto& row : tile.upper_forces)
        for (auto& half : row)
          for (V& value : half) value = V{};
      for (int p = -1; p <= brick_edge; ++p) sweep_plane<T, S, E>(sweep, lanes, brick, lines, index, p, v, tile, sum);
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
  table[int(Epilogue::force)] = sweep_bricks<T, S, Epilogue::force>;
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
