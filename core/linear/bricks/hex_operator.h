// The linear system's matrix as an operator that is applied and never stored: stiffness of rotated hexes (corotational,
// Mueller and Gross 2004) and a diagonal, on a lattice of bricks.
//
//   A = diag(w) + sum_e s_e Y R_e K R_e^T
// Node vectors stand in bricks (core/linear/bricks/brick.h), zero at nodes that are fixed or not there; the result is
// zero there too. Deterministic: the same bits for any number of threads; another instruction set rounds differently.
#pragma once

#include <algorithm>
#include <cassert>
#include <vector>

#include "core/linear/bricks/brick_access.h"
#include "core/linear/bricks/hadamard_hex.h"

namespace umax {

/// A's values; S: float or double.
template <class S>
struct HexMatrix {
  AlignedArray<S> frames;    // 9 per cell: sqrt(s_e Y) R_e row-major [sqrt(Pa)]
  AlignedArray<S> diagonal;  // per node: w [N/m], e.g. mass / h^2; > 0 free, < 0 fixed, 0 where there is no node
};

template <class S>
HexMatrix<S> make_hex_matrix(const BrickLattice& lattice) {
  return {AlignedArray<S>(lattice.num_slots() * frame_components), AlignedArray<S>(lattice.num_slots())};
}

/// Lattice, box constants and kernels: what does not change from step to step.
struct HexOperator {
  BrickLattice lattice;
  HexConstants<double> constants;
  HexConstants<float> float_constants;
  InstructionSet instruction_set = InstructionSet::portable;
};

HexOperator make_hex_operator(BrickLattice lattice, const HexShape& box,
                              InstructionSet instruction_set = best_instruction_set());

/// out = A x; returns x . A x.
double apply(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& x,
             AlignedArray<float>& out);

/// out = b - A x; returns its squared norm (before rounding to float).
double residual(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& b,
                const AlignedArray<float>& x, AlignedArray<float>& out);

/// Coefficients of next = keep x + momentum previous + gain D^-1 (b - A x).
struct ChebyshevStep {
  float keep = 1, momentum = 0, gain = 0;
};

/// Overwrites `previous` with the next iterate; inverse: D^-1 (6 per node). Returns b . next.
double chebyshev(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& inverse,
                 const ChebyshevStep& step, const AlignedArray<float>& b, const AlignedArray<float>& x,
                 AlignedArray<float>& previous);

/// Sets the frames: R_e from the deformation gradient at each cell's centre, s_e from `stiffness` (s Y per cell [Pa]).
void set_frames(const HexOperator& op, const AlignedArray<double>& positions, const AlignedArray<float>& stiffness,
                HexMatrix<float>& matrix);

/// Where masks (64 per brick) have a bit set, the frame is sqrt(s) times any matrix of norm sqrt(3): makes it one of
/// that matrix's polar factor (core/element/rotation.h).
void resolve_frames(const std::vector<std::uint16_t>& masks, AlignedArray<float>& frames);

/// Fills in what the operator and its matrix know and sweeps over the whole lattice; the epilogue's sum. `constants`: the
/// operator's, in T.
template <class T, class S>
double run(const HexOperator& op, const HexConstants<T>& constants, const HexMatrix<S>& matrix,
           SweepFunction<T, S> function, Sweep<T, S> sweep) {
  assert(sweep.out != sweep.x);
  sweep.bricks = op.lattice.bricks.data();
  sweep.cell_masks = op.lattice.cell_masks.data();
  sweep.node_masks = op.lattice.node_masks.data();
  sweep.constants = &constants;
  const double* trilinear = op.constants.trilinear;
  const auto [least, most] = std::minmax({trilinear[0], trilinear[1], trilinear[2]});
  sweep.is_cube = most - least <= 1e-14 * most;
  sweep.frames = matrix.frames.data();
  sweep.diagonal = matrix.diagonal.data();
  return for_each_sweep_task(op.lattice,
                             [&](const BrickRun* first, const BrickRun* last) { return function(sweep, first, last); });
}

/// to = from at nodes, on all threads; both are zero elsewhere.
inline void copy(const BrickLattice& lattice, const AlignedArray<float>& from, AlignedArray<float>& to) {
  constexpr std::size_t line_values = brick_lanes * vector_components;
  for_each_column(lattice, [&](int first, int last) {
    for (std::size_t line = std::size_t(first) * brick_lines; line < std::size_t(last) * brick_lines; ++line)
      if (lattice.node_masks[line] != 0)
        std::copy_n(from.data() + line * line_values, line_values, to.data() + line * line_values);
    return 0.0;
  });
}

/// a . b of node vectors, summed in double and in a fixed order.
template <class T>
double dot(const BrickLattice& lattice, const AlignedArray<T>& a, const AlignedArray<T>& b) {
  constexpr std::size_t brick_values = brick_slots * vector_components;
  return for_each_column(lattice, [&](int first, int last) {
    double sums[brick_lanes] = {};
    for (std::size_t i = first * brick_values; i < last * brick_values; i += brick_lanes)
      for (int lane = 0; lane < brick_lanes; ++lane) sums[lane] += double(a[i + lane]) * double(b[i + lane]);
    double total = 0;
    for (const double sum : sums) total += sum;
    return total;
  });
}

}  // namespace umax
