// The sweep over bricks that applies the matrix-free operator (core/linear/bricks/hex_kernel.h says what it computes),
// compiled once for each instruction set.
#pragma once

#include "core/linear/bricks/hex_cell_kernel.h"

namespace umax::UMAX_SIMD {

inline constexpr int rows = brick_edge + 1;  // of cells that touch a brick's nodes, along x and y
template <class T>
inline constexpr int vectors = brick_lanes / width<T>;  // per line
inline constexpr int row_lines = rows + 1;              // of nodes in a plane of those cells

/// What a task keeps between rows of cells. Its address must not leave the inlined functions: the compiler would have
/// to suspect every store of changing it.
template <class T>
struct Tile {
  Vec<T> plane_modes[2][vectors<T>][rows][4][3];  // of the node planes before and after the cells, by row of cells
  Vec<T> upper_forces[vectors<T>][rows][4][3];    // that the cells of the plane before give to this one
  Vec<T> above[brick_edge][3];                    // that the vector of cells below gives to this one, by row
  T last_lanes[longest_run][brick_lines][3];      // the same at the end of each line of the bricks below
};

/// Where the lines of a node plane begin, and those of the cells below it.
template <class T, class S>
struct Lines {
  const T* nodes[row_lines];
  const T* next_nodes[row_lines];  // in the bricks above
  const S* frames[rows];           // where the row has cells
  unsigned cell_rows[vectors<T>];  // bit j: row j has cells in the vector
};

// Has a line with such a mask any of its points in vector v?
template <class T>
UMAX_INLINE bool has_any(std::uint16_t mask, int v) {
  return mask >> v * width<T> & ((1u << width<T>)-1);
}

// place of a line of the halo: which brick along the axis, and its index there
UMAX_INLINE int brick_step(int index) {
  return index < 0 ? -1 : index >= brick_edge ? 1 : 0;
}

// node plane p = -1 .. 8 count of a run, and cell plane p - 1
template <class T, class S>
UMAX_INLINE void find_lines(const Sweep<T, S>& sweep, const BrickRun& run, int p, Lines<T, S>& lines) {
  const auto column_of = [&](int plane) {  // the brick beside which a plane lies
    return plane < 0 ? 0 : plane < brick_edge * run.count ? plane / brick_edge : run.count - 1;
  };
  const int here = column_of(p), below = column_of(p - 1);
  const Brick& node_brick = sweep.bricks[run.bricks[here]];
  const Brick& cell_brick = sweep.bricks[run.bricks[below]];
  const int di = brick_step(p - brick_edge * here), below_di = brick_step(p - 1 - brick_edge * below);
  for (int v = 0; v < vectors<T>; ++v) lines.cell_rows[v] = 0;
  for (int j = -1; j <= brick_edge; ++j) {
    const int line = brick_edge * (p & (brick_edge - 1)) + (j & (brick_edge - 1));
    const std::int32_t* near = node_brick.near + near_index(di, brick_step(j), 0);
    lines.nodes[j + 1] = sweep.x + line_offset(near[0], line, vector_components);
    lines.next_nodes[j + 1] = sweep.x + line_offset(near[1], line, vector_components);
    if (j == brick_edge || p < 0) continue;
    const int cell_line = brick_edge * ((p - 1) & (brick_edge - 1)) + (j & (brick_edge - 1));
    const int brick = cell_brick.near[near_index(below_di, brick_step(j), 0)];
    lines.frames[j + 1] = sweep.frames + line_offset(brick, cell_line, frame_components);
    const std::uint16_t cells = sweep.cell_masks[brick * brick_lines + cell_line];
    for (int v = 0; v < vectors<T>; ++v) lines.cell_rows[v] |= unsigned(has_any<T>(cells, v)) << (j + 1);
  }
}

// sum and difference along z of a node line: s[0 .. 2], s[3 .. 5]
template <class T, class S>
UMAX_INLINE void transform_line(const Lines<T, S>& lines, int j, int v, Vec<T> (&s)[2][3]) {
  const bool last = (v + 1) * width<T> == brick_lanes;
  const T* line = lines.nodes[j] + v * width<T>;
  const T* next = last ? lines.next_nodes[j] : line + width<T>;
  for (int c = 0; c < 3; ++c) {
    const Vec<T> x = load<T>(line + c * brick_lanes);
    const Vec<T> x1 = shift_down(x, load<T>(next + c * brick_lanes));
    s[0][c] = x1 + x;
    s[1][c] = x1 - x;
  }
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

template <class T, class S, Epilogue E>
UMAX_INLINE void finish(const Sweep<T, S>& sweep, const Lanes<T>& lanes, std::size_t slot, int lane, Vec<T>* y,
                        Vec<T>& sum) {
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

// back along z at a node line: y from the sums h of its even and odd parts
template <class T>
UMAX_INLINE void finish_line(const Vec<T> (&h)[2][3], int v, Vec<T>* above, T* last_lanes, Vec<T>* y) {
  for (int c = 0; c < 3; ++c) {
    const Vec<T> up = h[0][c] + h[1][c];
    const Vec<T> before = v == 0 ? broadcast<T>(last_lanes[c]) : above[c];
    y[c] = (h[0][c] - h[1][c]) + shift_up(before, up);
    if (v + 1 == vectors<T>)
      last_lanes[c] = up[width<T> - 1];
    else
      above[c] = up;
  }
}

// The same where the vector has no nodes, and so no cells.
template <class T>
UMAX_INLINE void give_nothing(int v, Vec<T>* above, T* last_lanes) {
  for (int c = 0; c < 3; ++c) {
    if (v + 1 == vectors<T>)
      last_lanes[c] = 0;
    else
      above[c] = Vec<T>{};
  }
}

// Rows of cells before the lower of two node planes, between them and behind the upper one, a bit each.
struct CellRows {
  unsigned before = 0, between = 0, behind = 0;
};

// One vector of cells along z for all rows between two node planes: completes the lower plane, which is plane p - 1 of
// the run, where it is one of the run's own. What would only add zeros is left out: much of a brick may be empty.
template <class T, class S, Epilogue E>
UMAX_INLINE void sweep_plane(const Sweep<T, S>& sweep, const Lanes<T>& lanes, const BrickRun& run,
                             const Lines<T, S>& lines, const CellRows& cells, int p, int v, Tile<T>& tile,
                             Vec<T>& sum) {
  using V = Vec<T>;
  V left[2][3], carried[2][3];
  for (int c = 0; c < 3; ++c) carried[0][c] = carried[1][c] = V{};
  const int column = p > 0 ? (p - 1) / brick_edge : 0, first_line = brick_edge * ((p - 1) & (brick_edge - 1));
  const std::uint16_t* own_nodes = sweep.node_masks + run.bricks[column] * brick_lines + first_line;
  const unsigned seen = cells.between | cells.behind, pushing = cells.before | cells.between;
  for (int row = 0; row < rows; ++row) {
    V right[2][3], forces[8][3], h[2][3];
    const V(&before)[4][3] = tile.plane_modes[~p & 1][v][row];
    V(&after)[4][3] = tile.plane_modes[p & 1][v][row];
    V(&upper)[4][3] = tile.upper_forces[v][row];
    if (seen >> row & 1) {
      if (row == 0 || !(seen >> (row - 1) & 1)) transform_line(lines, row, v, left);
      transform_line(lines, row + 1, v, right);
      transform_row(right, left, after);
      end_of_stage(left);
      end_of_stage(after);
    }
    if (p < 0) continue;

    if (cells.between >> row & 1) {
      const S* frames = lines.frames[row] + v * width<T>;
      local_forces<T, S>(lanes, frames, after, before, forces);
      spread_even<T>(frames, forces, upper, carried[0], h[0]);
      end_of_stage(carried[0]);
      end_of_stage(h[0]);
      spread_odd<T>(frames, forces, upper, carried[1], h[1]);
    } else if ((pushing | pushing << 1) >> row & 1) {
      for (int part = 0; part < 2; ++part)
        for (int c = 0; c < 3; ++c) {
          spread(V(upper[part][c]), V(upper[2 + part][c]), carried[part][c], h[part][c]);
          upper[part][c] = upper[2 + part][c] = V{};
        }
    } else {
      for (int part = 0; part < 2; ++part)
        for (int c = 0; c < 3; ++c) h[part][c] = V{};
    }
    if (row == 0 || p == 0) continue;
    const int line = first_line + row - 1;
    T* last_lanes = tile.last_lanes[run.first_column + column][line];
    if (!has_any<T>(own_nodes[row - 1], v)) {
      give_nothing<T>(v, tile.above[row - 1], last_lanes);
      continue;
    }
    V y[3];
    finish_line<T>(h, v, tile.above[row - 1], last_lanes, y);
    finish<T, S, E>(sweep, lanes, line_offset(run.bricks[column], line, 1), v * width<T>, y, sum);
  }
}

template <class T, class S, Epilogue E>
double sweep_runs(const Sweep<T, S>& sweep, const BrickRun* first, const BrickRun* last) {
  using V = Vec<T>;
  const Lanes<T> lanes = broadcast_all(sweep);
  Tile<T> tile;
  Lines<T, S> lines[2];  // of a plane and the next one
  double total = 0;
  for (const BrickRun* run = first; run < last; ++run) {
    for (int n = 0; n < run->count; ++n)
      if (!sweep.bricks[run->bricks[n]].continues)
        __builtin_memset(tile.last_lanes[run->first_column + n], 0, sizeof(tile.last_lanes[0]));
    for (auto& row : tile.upper_forces)
      for (auto& halves : row)
        for (auto& half : halves)
          for (V& value : half) value = V{};
    V sum{};
    const int last_plane = brick_edge * run->count;
    CellRows cells[vectors<T>];
    find_lines(sweep, *run, -1, lines[1]);
    for (int p = -1; p <= last_plane; ++p) {
      const Lines<T, S>& here = lines[p & 1];
      Lines<T, S>& next = lines[~p & 1];
      if (p < last_plane) find_lines(sweep, *run, p + 1, next);
      for (int v = 0; v < vectors<T>; ++v) {
        cells[v] = {cells[v].between, here.cell_rows[v], p < last_plane ? next.cell_rows[v] : 0};
        sweep_plane<T, S, E>(sweep, lanes, *run, here, cells[v], p, v, tile, sum);
      }
    }
    total += sum_of_lanes<T>(sum);
  }
  return total;
}

}  // namespace umax::UMAX_SIMD
