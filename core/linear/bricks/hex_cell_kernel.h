// The product of a hex's stiffness with its nodes' values, for a vector of hexes at once, in the Walsh-Hadamard basis.
// Compiled once for each instruction set, with core/linear/bricks/hex_kernel_body.h.
#pragma once

#include "core/base/simd.h"
#include "core/linear/bricks/hex_kernel.h"

namespace umax::UMAX_SIMD {

// what a task has in registers' width from the start: the constants in every lane
template <class T>
struct Lanes {
  HexConstants<Vec<T>> hex;
  Vec<T> keep, momentum, gain;
  bool is_cube;
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
  lanes.is_cube = sweep.is_cube;
  return lanes;
}

// Values computed so far go to memory where 16 registers hold one group of modes: left to itself the compiler mixes the
// stages and spills. The 32 of AVX-512 hold them, and sweeps take 0.7 times as long.
template <class A>
UMAX_INLINE void end_of_stage(A& values) {
#if UMAX_SIMD_BYTES < 64
  asm volatile("" : "+m"(values));
#else
  (void)values;
#endif
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

// Modes have the bits of the axes in which they alternate, x 4, y 2, z 1. Along x, then into the cells' frames Q:
// r = Q^T u for `count` modes at once, an outer product for each component, so that a frame is read once for all
template <class T, class S, int count>
UMAX_INLINE void to_local(const S* frames, const int (&modes)[count], const Vec<T> (&after)[4][3],
                          const Vec<T> (&before)[4][3], Vec<T> (&r)[count][3]) {
  using V = Vec<T>;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    V u[count];
    for (int m = 0; m < count; ++m) {
      const int half = modes[m] & 3;
      u[m] = modes[m] & 4 ? after[half][i] - before[half][i] : after[half][i] + before[half][i];
    }
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      const V q = load<T>(frames + (3 * i + c) * brick_lanes);
      for (int m = 0; m < count; ++m) r[m][c] = i == 0 ? q * u[m] : multiply_add(q, u[m], r[m][c]);
    }
  }
}

// r = Q u
template <class T, class S, int count>
UMAX_INLINE void to_world(const S* frames, const Vec<T>* const (&u)[count], Vec<T> (&r)[count][3]) {
  using V = Vec<T>;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i)
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      const V q = load<T>(frames + (3 * c + i) * brick_lanes);
      for (int m = 0; m < count; ++m) r[m][c] = i == 0 ? q * u[m][i] : multiply_add(q, u[m][i], r[m][c]);
    }
}

// K Q^T u of all modes, the last one's in the world's frame: Q K Q^T u
template <class T, class S>
UMAX_INLINE void local_forces(const Lanes<T>& lanes, const S* frames, const Vec<T> (&after)[4][3],
                              const Vec<T> (&before)[4][3], Vec<T> (&forces)[8][3]) {
  const HexConstants<Vec<T>>& k = lanes.hex;
  {
    Vec<T> r[3][3];  // x, y, z
    to_local<T, S, 3>(frames, {4, 2, 1}, after, before, r);
    multiply_triple(k.normal, r[0][0], r[1][1], r[2][2]);
    multiply_pair(k.shear[0], r[0][1], r[1][0]);
    multiply_pair(k.shear[1], r[0][2], r[2][0]);
    multiply_pair(k.shear[2], r[1][2], r[2][1]);
    for (int c = 0; c < 3; ++c) forces[4][c] = r[0][c], forces[2][c] = r[1][c], forces[1][c] = r[2][c];
    end_of_stage(forces);
  }
  {
    Vec<T> r[3][3];  // xy, xz, yz
    to_local<T, S, 3>(frames, {6, 5, 3}, after, before, r);
    multiply_pair(k.bend[0], r[0][1], r[1][2]);
    multiply_pair(k.bend[1], r[0][0], r[2][2]);
    multiply_pair(k.bend[2], r[1][0], r[2][1]);
    multiply_triple(k.twist, r[2][0], r[1][1], r[0][2]);
    for (int c = 0; c < 3; ++c) forces[6][c] = r[0][c], forces[5][c] = r[1][c], forces[3][c] = r[2][c];
    end_of_stage(forces);
  }
  if (lanes.is_cube) {  // s times a number, in any frame
    Vec<T> s{};
    for (int r = 0; r < 3; ++r) {
      const Vec<T> q = load<T>(frames + r * brick_lanes);
      s = multiply_add(q, q, s);
    }
    for (int c = 0; c < 3; ++c) forces[7][c] = (s * k.trilinear[0]) * (after[3][c] - before[3][c]);
  } else {
    Vec<T> r[1][3];  // xyz
    to_local<T, S, 1>(frames, {7}, after, before, r);
    for (int c = 0; c < 3; ++c) r[0][c] *= k.trilinear[c];
    Vec<T> world[1][3];
    to_world<T, S, 1>(frames, {r[0]}, world);
    for (int c = 0; c < 3; ++c) forces[7][c] = world[0][c];
  }
  end_of_stage(forces);
}

// What a row of cells leaves: `upper` for the plane above by halves, `carried` for the next line by parts (even and odd
// along z), and h: the sums at this line, by parts.
template <class V>
UMAX_INLINE void spread(const V& low, const V& high, V& carried, V& h) {
  h = carried + (low - high);
  carried = low + high;
}

// even part: modes x, y, xy
template <class T, class S>
UMAX_INLINE void spread_even(const S* frames, const Vec<T> (&forces)[8][3], Vec<T> (&upper)[4][3], Vec<T>* carried,
                             Vec<T>* h) {
  Vec<T> r[3][3];
  to_world<T, S, 3>(frames, {forces[4], forces[2], forces[6]}, r);
  for (int c = 0; c < 3; ++c) {
    const Vec<T> low = upper[0][c] - r[0][c], high = upper[2][c] + (r[1][c] - r[2][c]);
    upper[0][c] = r[0][c];
    upper[2][c] = r[1][c] + r[2][c];
    spread(low, high, carried[c], h[c]);
  }
}

// odd part: z and xz, then yz and xyz
template <class T, class S>
UMAX_INLINE void spread_odd(const S* frames, const Vec<T> (&forces)[8][3], Vec<T> (&upper)[4][3], Vec<T>* carried,
                            Vec<T>* h) {
  Vec<T> low[3], r[2][3];
  to_world<T, S, 2>(frames, {forces[1], forces[5]}, r);
  for (int c = 0; c < 3; ++c) {
    low[c] = upper[1][c] + (r[0][c] - r[1][c]);
    upper[1][c] = r[0][c] + r[1][c];
  }
  end_of_stage(upper[1]);
  Vec<T> yz[1][3];
  to_world<T, S, 1>(frames, {forces[3]}, yz);
  for (int c = 0; c < 3; ++c) {
    const Vec<T> high = upper[3][c] + (yz[0][c] - forces[7][c]);
    upper[3][c] = yz[0][c] + forces[7][c];
    spread(low[c], high, carried[c], h[c]);
  }
}

}  // namespace umax::UMAX_SIMD
