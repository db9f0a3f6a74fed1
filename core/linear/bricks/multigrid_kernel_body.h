// The loops that core/linear/bricks/hex_kernel.h and multigrid_kernel.h declare: hex_kernel_<instruction set>.cpp compile
// this one source under their own compiler options.
#pragma once

#include "core/linear/bricks/frame_kernel.h"
#include "core/linear/bricks/hex_kernel_body.h"
#include "core/linear/bricks/multigrid_kernel.h"

namespace umax::UMAX_SIMD {

// what one line of cells adds to the blocks of the nodes along one of its edges: `lower` at k, `upper` at k + 1;
// sx, sy: +1 where the edge is on the cells' upper side
UMAX_INLINE void add_blocks(const HexConstants<float>& k, const F* q, float sx, float sy, F* lower, F* upper) {
  constexpr int xx = 0, xy = 1, xz = 2, yy = 3, yz = 4, zz = 5;  // of k.corner
  F x[3], y[3], z[3], ax[3], ay[3], az[3], b[3];
  for (int r = 0; r < 3; ++r) {
    x[r] = q[3 * r], y[r] = q[3 * r + 1], z[r] = q[3 * r + 2];
    ax[r] = x[r] * k.corner[xx] + y[r] * (sx * sy * k.corner[xy]);
    ay[r] = y[r] * k.corner[yy] + x[r] * (sx * sy * k.corner[xy]);
    az[r] = z[r] * k.corner[zz];
    b[r] = x[r] * (sx * k.corner[xz]) + y[r] * (sy * k.corner[yz]);
  }
  int next = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = r; c < 3; ++c, ++next) {
      const F even = ax[r] * x[c] + ay[r] * y[c] + az[r] * z[c];
      const F odd = b[r] * z[c] + z[r] * b[c];
      lower[next] += even - odd;
      upper[next] += even + odd;
    }
}

// symmetric 3 x 3 inverse by cofactors, 0 where test is not positive
UMAX_INLINE void store_inverse(const F* d, F test, float* to) {
  const F c00 = d[3] * d[5] - d[4] * d[4], c01 = d[2] * d[4] - d[1] * d[5], c02 = d[1] * d[4] - d[2] * d[3];
  const F one_over_det = where_positive<float>(test, 1 / (d[0] * c00 + d[1] * c01 + d[2] * c02));
  const F inverse[6] = {c00, c01, c02, d[0] * d[5] - d[2] * d[2], d[1] * d[2] - d[0] * d[4], d[0] * d[3] - d[1] * d[1]};
  for (int r = 0; r < inverse_components; ++r)
    store<float>(to + r * brick_lanes, where_positive<float>(test, inverse[r] * one_over_det));
}

inline void invert_blocks(const BlockInversion& task, int first, int last) {
  F above[brick_lines][inverse_components];
  for (int index = first; index < last; ++index) {
    const Brick& brick = task.bricks[index];
    if (!brick.continues) __builtin_memset(above, 0, sizeof(above));
    for (int line = 0; line < brick_lines; ++line)
      for (int v = 0; v < vectors<float>; ++v) {
        F lower[inverse_components] = {}, upper[inverse_components] = {};
        for (int di = 0; di < 2; ++di)
          for (int dj = 0; dj < 2; ++dj) {
            const int i = line / brick_edge - di, j = line % brick_edge - dj;
            const int other = brick.near[near_index(brick_step(i), brick_step(j), 0)];
            const int other_line = brick_edge * (i & (brick_edge - 1)) + (j & (brick_edge - 1));
            if (!(task.bricks[other].cell_lines >> other_line & 1)) continue;
            const float* frames = task.frames + line_offset(other, other_line, frame_components) + v * width<float>;
            F q[frame_components];
            for (int r = 0; r < frame_components; ++r) q[r] = load<float>(frames + r * brick_lanes);
            add_blocks(*task.constants, q, di ? 1.f : -1.f, dj ? 1.f : -1.f, lower, upper);
          }
        const std::size_t slot = line_offset(index, line, 1);
        const F w = load<float>(task.diagonal + slot + v * width<float>);
        for (int r = 0; r < inverse_components; ++r) {
          lower[r] += shift_up(above[line][r], upper[r]);
          above[line][r] = upper[r];
        }
        lower[0] += w, lower[3] += w, lower[5] += w;
        store_inverse(lower, w, task.inverse + inverse_components * slot + v * width<float>);
      }
  }
}

// Fine line (i, j), counted from a coarse brick's first: adds its values at k = -1 .. 16 factor - 1, weighted, to
// sums[c][k + 1].
template <int components>
UMAX_INLINE void add_weighted_line(const Transfer& t, const BrickParents& parents, int i, int j, const float* fine,
                                   float weight, float (&sums)[components][2 * brick_lanes + 1]) {
  const int column = ((i + brick_edge) / brick_edge) * 9 + ((j + brick_edge) / brick_edge) * 3;
  const int line = brick_edge * (i & (brick_edge - 1)) + (j & (brick_edge - 1));
  const float* below = fine + line_offset(parents.fine[column], line, components);
  const float* here = fine + line_offset(parents.fine[column + 1], line, components);
  const float* next = fine + line_offset(parents.fine[column + 2], line, components);
  for (int c = 0; c < components; ++c, below += brick_lanes, here += brick_lanes, next += brick_lanes) {
    for (int k = 0; k < brick_lanes; ++k) sums[c][1 + k] += weight * here[k];
    if (t.factor[2] == 1) continue;
    sums[c][0] += weight * below[brick_lanes - 1];
    for (int k = 0; k < brick_lanes; ++k) sums[c][1 + brick_lanes + k] += weight * next[k];
  }
}

template <int components>
void restrict_nodes(const Transfer& t, const float* fine, float* coarse, int first, int last) {
  for (int index = first; index < last; ++index)
    for (int line = 0; line < brick_lines; ++line) {
      if (!(t.coarse_bricks[index].node_lines >> line & 1)) continue;
      const int i = t.factor[0] * (line / brick_edge), j = t.factor[1] * (line % brick_edge);
      const int ri = t.factor[0] - 1, rj = t.factor[1] - 1;  // reach of the weights
      float sums[components][2 * brick_lanes + 1] = {};
      for (int di = -ri; di <= ri; ++di)
        for (int dj = -rj; dj <= rj; ++dj)
          add_weighted_line<components>(t, t.parents[index], i + di, j + dj, fine,
                                        (di ? 0.5f : 1.f) * (dj ? 0.5f : 1.f), sums);
      float* to = coarse + line_offset(index, line, components);
      for (int c = 0; c < components; ++c, to += brick_lanes)
        if (t.factor[2] == 1)
          for (int k = 0; k < brick_lanes; ++k) to[k] = sums[c][1 + k];
        else
          for (int k = 0; k < brick_lanes; ++k)
            to[k] = sums[c][2 * k + 1] + 0.5f * (sums[c][2 * k] + sums[c][2 * k + 2]);
    }
}

// What a line of a fine brick gets from up to four coarse ones: mean of their values at k = 0 .. 8 or, where z is not
// coarsened, 0 .. 15.
UMAX_INLINE void coarse_mean(const Transfer& t, const BrickChildren& children, int line, const float* coarse,
                             float (&mean)[3][brick_lanes]) {
  constexpr int half = brick_lanes / 2;
  const int i = line / brick_edge + brick_edge * children.half[0],
            j = line % brick_edge + brick_edge * children.half[1];
  const int ni = i % t.factor[0] + 1, nj = j % t.factor[1] + 1;  // coarse lines on both sides, or one
  const float weight = 1.f / float(ni * nj);
  for (int n = 0; n < ni * nj; ++n) {
    const int ci = i / t.factor[0] + n / nj, cj = j / t.factor[1] + n % nj;
    const int column = 4 * (ci / brick_edge) + 2 * (cj / brick_edge);
    const int coarse_line = brick_edge * (ci % brick_edge) + cj % brick_edge;
    const float* from = coarse + line_offset(children.coarse[column], coarse_line, 3);
    const float* next = coarse + line_offset(children.coarse[column + 1], coarse_line, 3);
    for (int c = 0; c < 3; ++c, from += brick_lanes, next += brick_lanes) {
      if (t.factor[2] == 1) {
        for (int k = 0; k < brick_lanes; ++k) mean[c][k] += weight * from[k];
      } else {
        const float* start = from + half * children.half[2];
        for (int k = 0; k < half; ++k) mean[c][k] += weight * start[k];
        mean[c][half] += weight * (children.half[2] ? next[0] : from[half]);
      }
    }
  }
}

inline void prolong(const Transfer& t, const float* coarse, const float* diagonal, float* fine, int first, int last) {
  constexpr int half = brick_lanes / 2;
  for (int index = first; index < last; ++index)
    for (int line = 0; line < brick_lines; ++line) {
      if (!(t.fine_bricks[index].node_lines >> line & 1)) continue;
      float mean[3][brick_lanes] = {};
      coarse_mean(t, t.children[index], line, coarse, mean);
      float* to = fine + line_offset(index, line, 3);
      const float* w = diagonal + line_offset(index, line, 1);
      for (int c = 0; c < 3; ++c, to += brick_lanes) {
        float steps[brick_lanes];
        if (t.factor[2] == 2)
          for (int k = 0; k < half; ++k) {
            steps[2 * k] = mean[c][k];
            steps[2 * k + 1] = 0.5f * (mean[c][k] + mean[c][k + 1]);
          }
        else
          for (int k = 0; k < brick_lanes; ++k) steps[k] = mean[c][k];
        for (int lane = 0; lane < brick_lanes; lane += width<float>)
          store<float>(to + lane, load<float>(to + lane) +
                                      where_positive<float>(load<float>(w + lane), load<float>(steps + lane)));
      }
    }
}

inline void block_jacobi(const BlockJacobi& task, int first, int last) {
  for (std::size_t line = std::size_t(first) * brick_lines; line < std::size_t(last) * brick_lines; ++line)
    for (int v = 0; v < vectors<float>; ++v) {
      if (!has_any<float>(task.node_masks[line], v)) continue;
      const int lane = v * width<float>;
      F d[inverse_components], r[3];
      for (int q = 0; q < inverse_components; ++q)
        d[q] = load<float>(task.inverse + (line * inverse_components + q) * brick_lanes + lane);
      for (int c = 0; c < 3; ++c) r[c] = task.gain * load<float>(task.b + (line * 3 + c) * brick_lanes + lane);
      const F z[3] = {d[0] * r[0] + d[1] * r[1] + d[2] * r[2], d[1] * r[0] + d[3] * r[1] + d[4] * r[2],
                      d[2] * r[0] + d[4] * r[1] + d[5] * r[2]};
      for (int c = 0; c < 3; ++c) store<float>(task.x + (line * 3 + c) * brick_lanes + lane, z[c]);
    }
}

inline constexpr std::size_t brick_values = brick_slots * vector_components;

inline void turn(const float* z, float beta, float* p, int first, int last) {
  for (std::size_t i = first * brick_values; i < last * brick_values; i += width<float>)
    store<float>(p + i, load<float>(z + i) + beta * load<float>(p + i));
}

inline void sweep_slices(const SliceSweep& sweep, int first, int last) {
  const EllSlices& slices = sweep.slices;
  for (int s = first; s < last; ++s) {
    F sums[vectors<float>] = {};
    for (std::int32_t e = slices.starts[s]; e < slices.starts[s + 1]; ++e)
      for (int v = 0; v < vectors<float>; ++v)
        sums[v] = multiply_add(load_short(slices.entries + std::size_t(e) * brick_lanes + v * width<float>),
                               load<float>(sweep.move + slices.places[e] + v * width<float>), sums[v]);
    const std::size_t inner = std::size_t(s) * brick_lanes, outer = std::size_t(s) * slice_stride + 1;
    for (int v = 0; v < vectors<float>; ++v) {
      const std::size_t lane = std::size_t(v) * width<float>;
      const F move = load<float>(sweep.move + outer + lane);
      const F rest = load<float>(sweep.rest + inner + lane) - (move + slices.unit * sums[v]);
      const F next = sweep.momentum * move + sweep.gain * rest;
      store<float>(sweep.rest + inner + lane, rest);
      store<float>(sweep.next + outer + lane, next);
      store<float>(sweep.x + inner + lane, load<float>(sweep.x + inner + lane) + next);
    }
    if (slices.below[s] >= 0)
      sweep.next[std::size_t(slices.below[s]) * slice_stride + brick_lanes + 1] = sweep.next[outer];
    if (slices.above[s] >= 0)
      sweep.next[std::size_t(slices.above[s]) * slice_stride] = sweep.next[outer + brick_lanes - 1];
  }
}

inline constexpr HexKernels hex_kernels = {{sweep_runs<float, float, Epilogue::apply>,
                                            sweep_runs<float, float, Epilogue::residual>,
                                            sweep_runs<float, float, Epilogue::chebyshev>}};

inline constexpr MultigridKernels multigrid_kernels = {
    invert_blocks, coarsen_frames, find_rotations, restrict_nodes<3>, restrict_nodes<1>,
    prolong,       block_jacobi,   turn,           sweep_slices};

}  // namespace umax::UMAX_SIMD

namespace umax {

// NOLINTBEGIN(misc-definitions-in-headers): included once for each instruction set
template <>
const HexKernels& kernels_for<HexKernels, InstructionSet::UMAX_SIMD>() {
  return UMAX_SIMD::hex_kernels;
}
template <>
const MultigridKernels& kernels_for<MultigridKernels, InstructionSet::UMAX_SIMD>() {
  return UMAX_SIMD::multigrid_kernels;
}
// NOLINTEND(misc-definitions-in-headers)

}  // namespace umax
