// Inner loops that find the rotations of cells: from the positions of their nodes, and for a coarse cell from the fine
// ones in it. Polar factors by Newton's iteration (Higham 1986, Computing the polar decomposition). Compiled once for
// each instruction set, with core/linear/bricks/multigrid_kernel_body.h.
#pragma once

#include "core/base/simd.h"
#include "core/linear/bricks/multigrid_kernel.h"

namespace umax::UMAX_SIMD {

using F = Vec<float>;

// Polar factors by Newton's iteration X <- (X + X^-T) / 2; a bit of the result is set where that did not end in a
// rotation. Matrices of norm sqrt(3) come in.
UMAX_INLINE unsigned polar(F* X) {
  constexpr int iterations = 6;
  F error{};
  for (int iteration = 0; iteration < iterations; ++iteration) {
    F C[9];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
        C[3 * r + c] = X[3 * r1 + c1] * X[3 * r2 + c2] - X[3 * r1 + c2] * X[3 * r2 + c1];
      }
    const F half_over_det = 0.5f / (X[0] * C[0] + X[1] * C[1] + X[2] * C[2]);
    error = F{} - 3;
    for (int r = 0; r < 9; ++r) {
      X[r] = 0.5f * X[r] + half_over_det * C[r];
      error += X[r] * X[r];
    }
    error = where_positive<float>(half_over_det, error + 1) - 1;  // improper: -1
  }
  unsigned unresolved = 0;
  for (int lane = 0; lane < width<float>; ++lane)
    unresolved |= unsigned(!(error[lane] < 1e-4f && error[lane] > -1e-4f)) << lane;
  return unresolved;
}

// a line of coarse cells: sums of s and of s R over the fine ones
struct CoarseLine {
  float stiffness[brick_lanes] = {};
  float frames[frame_components][brick_lanes] = {};
};

inline void add_fine_line(const float* fine, int factor, int offset, CoarseLine& line) {
  float weighted[frame_components + 1][brick_lanes];
  for (int k = 0; k < brick_lanes; ++k) {
    float squared = 0;
    for (int r = 0; r < frame_components; ++r) squared += fine[r * brick_lanes + k] * fine[r * brick_lanes + k];
    weighted[frame_components][k] = squared / 3;
  }
  for (int k = 0; k < brick_lanes; ++k) {
    const float root = __builtin_sqrtf(weighted[frame_components][k]);
    for (int r = 0; r < frame_components; ++r) weighted[r][k] = root * fine[r * brick_lanes + k];
  }
  for (int r = 0; r <= frame_components; ++r) {
    float* to = r < frame_components ? line.frames[r] : line.stiffness;
    if (factor == 1)
      for (int k = 0; k < brick_lanes; ++k) to[k] += weighted[r][k];
    else
      for (int k = 0; k < brick_lanes / 2; ++k) to[offset + k] += weighted[r][2 * k] + weighted[r][2 * k + 1];
  }
}

// a line of frames: sqrt(s) times the polar factors of matrices, where sum of squares > clear; else of the identity.
// Returns the cells for which it failed: those keep the matrix, scaled to the norm of a rotation
inline unsigned store_frames(const float (&matrices)[frame_components][brick_lanes], const float* stiffness,
                             const float* clear, float* out) {
  unsigned unresolved = 0;
  for (int v = 0; v < brick_lanes / width<float>; ++v) {
    const int lane = v * width<float>;
    F X[frame_components], before[frame_components], squared{};
    for (int r = 0; r < frame_components; ++r) {
      X[r] = load<float>(matrices[r] + lane);
      squared += X[r] * X[r];
    }
    const F is_clear = squared - load<float>(clear + lane), scale = 1.7320508f / square_root<float>(squared);
    for (int r = 0; r < frame_components; ++r)
      before[r] = X[r] = is_clear > 0 ? X[r] * scale : F{} + (r % 4 == 0 ? 1.f : 0.f);
    unsigned failed = polar(X);
    for (int i = 0; i < width<float>; ++i)
      if (!(stiffness[lane + i] > 0)) failed &= ~(1u << i);
    unresolved |= failed << lane;
    const F root = square_root<float>(load<float>(stiffness + lane));
    for (int r = 0; r < frame_components; ++r) {
      for (int i = 0; i < width<float>; ++i)
        if (failed >> i & 1) X[r][i] = before[r][i];
      store<float>(out + r * brick_lanes + lane, where_positive<float>(root, root * X[r]));
    }
  }
  return unresolved;
}

inline void coarsen_frames(const FrameCoarsening& task, int first, int last) {
  const Transfer& t = task.transfer;
  for (int index = first; index < last; ++index)
    for (int line = 0; line < brick_lines; ++line) {
      if (!(t.coarse_bricks[index].cell_lines >> line & 1)) continue;
      CoarseLine sums;
      for (int a = 0; a < t.factor[0]; ++a)
        for (int b = 0; b < t.factor[1]; ++b)
          for (int half = 0; half < t.factor[2]; ++half) {
            const int i = t.factor[0] * (line / brick_edge) + a, j = t.factor[1] * (line % brick_edge) + b;
            const int parent = (i / brick_edge + 1) * 9 + (j / brick_edge + 1) * 3 + half + 1;
            const int fine = t.parents[index].fine[parent];
            if (fine == 0) continue;
            const int fine_line = brick_edge * (i % brick_edge) + j % brick_edge;
            add_fine_line(task.fine + line_offset(fine, fine_line, frame_components), t.factor[2],
                          half * brick_lanes / 2, sums);
          }
      const float num_fine = float(t.factor[0] * t.factor[1] * t.factor[2]);
      float clear[brick_lanes];
      for (int k = 0; k < brick_lanes; ++k) {
        clear[k] = 1e-12f * sums.stiffness[k] * sums.stiffness[k];
        sums.stiffness[k] /= num_fine;
      }
      task.unresolved[index * brick_lines + line] = std::uint16_t(
          store_frames(sums.frames, sums.stiffness, clear, task.coarse + line_offset(index, line, frame_components)));
    }
}

// differences along x, y, z at the cells' centres of the node positions of one line of cells
inline void centre_differences(const double* const (&lines)[4], const double* const (&next)[4], int component,
                               double (&d)[3][brick_lanes]) {
  double p[4][brick_lanes + 1];
  for (int n = 0; n < 4; ++n) {
    for (int k = 0; k < brick_lanes; ++k) p[n][k] = lines[n][component * brick_lanes + k];
    p[n][brick_lanes] = next[n][component * brick_lanes];
  }
  for (int k = 0; k < brick_lanes; ++k) {
    double sum[4], rise = 0;
    for (int n = 0; n < 4; ++n) {
      sum[n] = p[n][k] + p[n][k + 1];
      rise += p[n][k + 1] - p[n][k];
    }
    d[0][k] = (sum[2] + sum[3]) - (sum[0] + sum[1]);
    d[1][k] = (sum[1] + sum[3]) - (sum[0] + sum[2]);
    d[2][k] = rise;
  }
}

inline void find_rotations(const RotationSearch& task, int first, int last) {
  for (int index = first; index < last; ++index)
    for (int line = 0; line < brick_lines; ++line) {
      const Brick& brick = task.bricks[index];
      if (!(brick.cell_lines >> line & 1)) continue;
      const double *lines[4], *next[4];
      for (int n = 0; n < 4; ++n) {
        const int i = line / brick_edge + (n >> 1), j = line % brick_edge + (n & 1);
        const int at = brick_edge * (i % brick_edge) + j % brick_edge;
        const int step = near_index(i / brick_edge, j / brick_edge, 0);
        lines[n] = task.positions + line_offset(brick.near[step], at, vector_components);
        next[n] = task.positions + line_offset(brick.near[step + 1], at, vector_components);
      }
      float gradients[frame_components][brick_lanes];
      for (int c = 0; c < 3; ++c) {
        double d[3][brick_lanes];
        centre_differences(lines, next, c, d);
        for (int axis = 0; axis < 3; ++axis)
          for (int k = 0; k < brick_lanes; ++k)
            gradients[3 * c + axis][k] = float(d[axis][k] * task.quarter_over_size[axis]);
      }
      const float collapsed[brick_lanes] = {};
      task.unresolved[index * brick_lines + line] =
          std::uint16_t(store_frames(gradients, task.stiffness + line_offset(index, line, 1), collapsed,
                                     task.frames + line_offset(index, line, frame_components)));
    }
}

}  // namespace umax::UMAX_SIMD
