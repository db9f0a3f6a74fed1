// The loops that core/element/hex_batch_kernel.h declares: hex_batch_kernel_<instruction set>.cpp compile this one source
// under their own compiler options. The numbers of a lane depend on no other lane; they are the same bits with every
// instruction set, as nothing is fused.
#pragma once

#include "core/base/simd.h"
#include "core/element/hex_batch_kernel.h"

namespace umax::UMAX_SIMD {

using D = Vec<double>;

UMAX_INLINE D larger(D a, D b) {
  return a > b ? a : b;
}
UMAX_INLINE D magnitude(D a) {
  return a < D{} ? -a : a;
}
template <class Mask>
UMAX_INLINE bool any(Mask mask) {
  bool found = false;
  for (int lane = 0; lane < width<double>; ++lane) found |= mask[lane] != 0;
  return found;
}

UMAX_INLINE void cofactors(const D* X, D* C) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      C[3 * r + c] = X[3 * r1 + c1] * X[3 * r2 + c2] - X[3 * r1 + c2] * X[3 * r2 + c1];
    }
}

template <int count>
UMAX_INLINE D square(const D* values) {
  D sum = values[0] * values[0];
  for (int i = 1; i < count; ++i) sum += values[i] * values[i];
  return sum;
}

// The polar factor of G by Newton's iteration, as polar_rotation(); lanes where G is no clear, proper deformation are set
// in `unresolved`, and are left at the identity.
UMAX_INLINE void polar(const D* G, D* X, D& unresolved) {
  constexpr double far = 0.1, converged = 1e-17, well_conditioned = 1e-3;
  constexpr int max_iterations = 16;
  D largest = magnitude(G[0]), C[9];
  for (int i = 1; i < 9; ++i) largest = larger(largest, magnitude(G[i]));
  const D scale = 1 / (largest > D{} ? largest : D{} + 1);
  for (int i = 0; i < 9; ++i) X[i] = G[i] * scale;
  cofactors(X, C);
  D det = X[0] * C[0] + X[1] * C[1] + X[2] * C[2];
  const D well = D{} + well_conditioned;
  unresolved = det > well ? D{} : D{} + 1;
  for (int i = 0; i < 9; ++i) {
    const D one = D{} + (i % 4 == 0 ? 1 : 0);
    X[i] = det > well ? X[i] : one;
    C[i] = det > well ? C[i] : one;
  }
  det = det > well ? det : D{} + 1;
  D change = D{} + 1;
  for (int k = 0; k < max_iterations && any(change > D{} + converged); ++k) {
    D a = D{} + 1;
    if (any(change > D{} + far)) {
      const D norms = square_root<double>(square<9>(C) / square<9>(X));
      a = change > D{} + far ? square_root<double>(norms / det) : a;
    }
    const D of_x = 0.5 * a, of_cofactors = 0.5 / (a * det);
    D next[9], moved[9];
    for (int i = 0; i < 9; ++i) {
      next[i] = of_x * X[i] + of_cofactors * C[i];
      moved[i] = next[i] - X[i];
    }
    const D old = change, moves = square<9>(moved);
    change = old > D{} + converged ? moves : old;
    for (int i = 0; i < 9; ++i) X[i] = old > D{} + converged ? next[i] : X[i];
    cofactors(X, C);
    det = X[0] * C[0] + X[1] * C[1] + X[2] * C[2];
  }
}

// g = K u
UMAX_INLINE void multiply_stiffness(const double* K, const D* u, D* g) {
  constexpr int rows = UMAX_SIMD_BYTES == 64 ? 24 : 12;  // sums that registers hold
  for (int first = 0; first < 24; first += rows) {
    D sums[rows];
    for (int r = 0; r < rows; ++r) sums[r] = K[first + r] * u[0];
    for (int c = 1; c < 24; ++c)
      for (int r = 0; r < rows; ++r) sums[r] += K[24 * c + first + r] * u[c];
    for (int r = 0; r < rows; ++r) g[first + r] = sums[r];
  }
}

// p = D^-1 t with D = tr(S) I - S; lanes where D is nearly singular are set in `unresolved`
UMAX_INLINE void solve_spin(const D* S, const D* t, D* p, D& unresolved) {
  constexpr double smallest_trusted_D = 1e-2;
  const D xx = S[4] + S[8], yy = S[0] + S[8], zz = S[0] + S[4], xy = -S[1], xz = -S[2], yz = -S[5];
  const D c00 = yy * zz - yz * yz, c01 = xz * yz - xy * zz, c02 = xy * yz - xz * yy;
  const D c11 = xx * zz - xz * xz, c12 = xy * xz - xx * yz, c22 = xx * yy - xy * xy;
  const D det = xx * c00 + xy * c01 + xz * c02, trace = xx + yy + zz;
  const D least = smallest_trusted_D * (trace * trace), scaled = 4 * det;
  unresolved = scaled > least ? unresolved : D{} + 1;
  const D over_det = 1 / (scaled > least ? det : D{} + 1);
  p[0] = over_det * (c00 * t[0] + c01 * t[1] + c02 * t[2]);
  p[1] = over_det * (c01 * t[0] + c11 * t[1] + c12 * t[2]);
  p[2] = over_det * (c02 * t[0] + c12 * t[1] + c22 * t[2]);
}

// of every node: to = R from, or R^T from
UMAX_INLINE void to_world(const D* R, const D* from, D* to) {
  for (int n = 0; n < 24; n += 3)
    for (int r = 0; r < 3; ++r)
      to[n + r] = R[3 * r] * from[n] + R[3 * r + 1] * from[n + 1] + R[3 * r + 2] * from[n + 2];
}
UMAX_INLINE void to_local(const D* R, const D* from, D* to) {
  for (int n = 0; n < 24; n += 3)
    for (int c = 0; c < 3; ++c) to[n + c] = from[n] * R[c] + from[n + 1] * R[3 + c] + from[n + 2] * R[6 + c];
}

template <int count>
UMAX_INLINE void load_all(const double (&from)[count][most_batched], int first, D (&to)[count]) {
  for (int i = 0; i < count; ++i) to[i] = load<double>(from[i] + first);
}
template <int count>
UMAX_INLINE void store_all(const D (&from)[count], int first, double (&to)[count][most_batched]) {
  for (int i = 0; i < count; ++i) store<double>(to[i] + first, from[i]);
}

// [first, first + lanes) of the batch
inline void multiply_lanes(const HexBatchShape& shape, int first, HexBatch& batch) {
  D x[24], R[9], local[24], g[24];
  load_all(batch.nodes, first, x);
  load_all(batch.rotation, first, R);
  to_local(R, x, local);
  multiply_stiffness(shape.stiffness, local, g);
  to_world(R, g, x);
  store_all(x, first, batch.gradient);
}

inline void evaluate_lanes(const HexBatchShape& shape, int first, HexBatch& batch) {
  D x[24], G[9], R[9], S[9], y[24], u[24], g[24];
  load_all(batch.nodes, first, x);
  for (int c = 0; c < 3; ++c) {
    D mean = x[c];
    for (int n = 1; n < 8; ++n) mean += x[3 * n + c];
    mean *= 0.125;
    for (int n = 0; n < 8; ++n) x[3 * n + c] -= mean;
  }
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      D sum = x[r] * shape.rotation_gradients[c];
      for (int n = 1; n < 8; ++n) sum += x[3 * n + r] * shape.rotation_gradients[3 * n + c];
      G[3 * r + c] = sum;
    }
  D unresolved;
  polar(G, R, unresolved);
  D RG[9];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) RG[3 * r + c] = R[r] * G[c] + R[3 + r] * G[3 + c] + R[6 + r] * G[6 + c];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) S[3 * r + c] = 0.5 * (RG[3 * r + c] + RG[3 * c + r]);
  to_local(R, x, y);
  for (int i = 0; i < 24; ++i) u[i] = y[i] - shape.rest_nodes[i];
  multiply_stiffness(shape.stiffness, u, g);

  D energy = u[0] * g[0], t[3] = {}, p[3];
  for (int i = 1; i < 24; ++i) energy += u[i] * g[i];
  for (int n = 0; n < 8; ++n)
    for (int c = 0; c < 3; ++c) {
      const int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      t[c] += y[3 * n + c1] * g[3 * n + c2] - y[3 * n + c2] * g[3 * n + c1];
    }
  solve_spin(S, t, p, unresolved);
  for (int n = 0; n < 8; ++n) {
    const double* h = shape.rotation_gradients + 3 * n;
    for (int c = 0; c < 3; ++c) {
      const int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      g[3 * n + c] -= p[c1] * h[c2] - p[c2] * h[c1];
    }
  }
  to_world(R, g, x);
  store_all(x, first, batch.gradient);
  store<double>(batch.energy + first, 0.5 * energy);
  store_all(R, first, batch.rotation);
  store_all(S, first, batch.stretch);
  store_all(y, first, batch.local_nodes);
  store_all(u, first, batch.displacement);
  for (int lane = 0; lane < width<double>; ++lane)
    batch.unresolved |= unsigned(unresolved[lane] != 0) << (first + lane);
}

inline void evaluate_batch(const HexBatchShape& shape, HexBatch& batch) {
  batch.unresolved = 0;
  for (int first = 0; first < most_batched; first += width<double>) evaluate_lanes(shape, first, batch);
}

inline void multiply_batch(const HexBatchShape& shape, HexBatch& batch) {
  for (int first = 0; first < most_batched; first += width<double>) multiply_lanes(shape, first, batch);
}

inline constexpr HexBatchKernels hex_batch_kernels = {evaluate_batch, multiply_batch};

}  // namespace umax::UMAX_SIMD

namespace umax {

// NOLINTBEGIN(misc-definitions-in-headers): included once for each instruction set
template <>
const HexBatchKernels& kernels_for<HexBatchKernels, InstructionSet::UMAX_SIMD>() {
  return UMAX_SIMD::hex_batch_kernels;
}
// NOLINTEND(misc-definitions-in-headers)

}  // namespace umax
