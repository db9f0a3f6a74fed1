#include "core/linear/bricks/hex_operator.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <type_traits>
#include <utility>

#include "core/element/rotation.h"
#include "core/linear/bricks/multigrid_kernel.h"

namespace umax {
namespace {

template <class T, class S>
SweepFunction<T, S> sweep_function(const HexKernels& kernels, Epilogue epilogue) {
  if constexpr (std::is_same_v<T, float>)
    return kernels.float_sweeps[int(epilogue)];
  else if constexpr (std::is_same_v<S, float>)
    return kernels.mixed_sweeps[int(epilogue)];
  else
    return kernels.double_sweeps[int(epilogue)];
}

template <class T, class S>
double run(const HexOperator& op, const HexMatrix<S>& matrix, Epilogue epilogue, Sweep<T, S> sweep) {
  assert(sweep.out != sweep.x);
  sweep.bricks = op.lattice.bricks.data();
  if constexpr (std::is_same_v<T, float>)
    sweep.constants = &op.float_constants;
  else
    sweep.constants = &op.constants;
  const double* trilinear = op.constants.trilinear;
  const auto [least, most] = std::minmax({trilinear[0], trilinear[1], trilinear[2]});
  sweep.is_cube = most - least <= 1e-14 * most;
  sweep.frames = matrix.frames.data();
  sweep.diagonal = matrix.diagonal.data();
  const SweepFunction<T, S> function = sweep_function<T, S>(hex_kernels(op.instruction_set), epilogue);
  return for_each_sweep_task(op.lattice,
                             [&](const BrickRun* first, const BrickRun* last) { return function(sweep, first, last); });
}

}  // namespace

template <class S>
HexMatrix<S> make_hex_matrix(const BrickLattice& lattice) {
  return {AlignedArray<S>(lattice.num_slots() * frame_components), AlignedArray<S>(lattice.num_slots())};
}

HexOperator make_hex_operator(BrickLattice lattice, const HexShape& box, InstructionSet instruction_set) {
  assert(is_supported(instruction_set));
  const HexConstants<double> constants = make_hex_constants(box);
  return {std::move(lattice), constants, to_float(constants), instruction_set};
}

template <class T, class S>
double apply(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<T>& x, AlignedArray<T>& out) {
  Sweep<T, S> sweep;
  sweep.x = x.data();
  sweep.out = out.data();
  return run(op, matrix, Epilogue::apply, sweep);
}

template <class T, class S>
double residual(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<T>& b, const AlignedArray<T>& x,
                AlignedArray<float>& out) {
  Sweep<T, S> sweep;
  sweep.x = x.data();
  sweep.b = b.data();
  sweep.out = out.data();
  return run(op, matrix, Epilogue::residual, sweep);
}

double chebyshev(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& inverse,
                 const ChebyshevStep& step, const AlignedArray<float>& b, const AlignedArray<float>& x,
                 AlignedArray<float>& previous) {
  Sweep<float, float> sweep;
  sweep.x = x.data();
  sweep.b = b.data();
  sweep.inverse = inverse.data();
  sweep.out = previous.data();
  sweep.keep = step.keep;
  sweep.momentum = step.momentum;
  sweep.gain = step.gain;
  return run(op, matrix, Epilogue::chebyshev, sweep);
}

template <class S>
void force(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& external,
           const AlignedArray<double>& positions, AlignedArray<double>& out) {
  Sweep<double, S> sweep;
  sweep.x = positions.data();
  sweep.b = external.data();
  sweep.out = out.data();
  for (int axis = 0; axis < 3; ++axis) sweep.rest[axis] = 4 * op.lattice.cell_size[axis];
  run(op, matrix, Epilogue::force, sweep);
}

void set_frames(const HexOperator& op, const AlignedArray<double>& positions, const AlignedArray<float>& stiffness,
                HexMatrix<float>& matrix) {
  std::vector<std::uint16_t> unresolved(op.lattice.bricks.size() * brick_lines, 0);
  RotationSearch task{op.lattice.bricks.data(), positions.data(), stiffness.data(), {},
                      matrix.frames.data(),     unresolved.data()};
  for (int axis = 0; axis < 3; ++axis) task.quarter_over_size[axis] = 0.25 / op.lattice.cell_size[axis];
  const MultigridKernels& kernels = multigrid_kernels(op.instruction_set);
  for_each_column(op.lattice, [&](int first, int last) {
    kernels.find_rotations(task, first, last);
    return 0.0;
  });
  resolve_frames(unresolved, matrix.frames);  // collapsed or inside out
}

void resolve_frames(const std::vector<std::uint16_t>& masks, AlignedArray<float>& frames) {
  for (std::size_t line = 0; line < masks.size(); ++line)
    for (int lane = 0; lane < brick_lanes; ++lane) {
      if (!(masks[line] >> lane & 1)) continue;
      const int slot = int(line) * brick_lanes + lane;
      const Matrix3d Q = frame_at(frames, slot);
      set_frame_at(slot, std::sqrt(Q.squaredNorm() / 3) * polar_rotation(Q), frames);
    }
}

template HexMatrix<float> make_hex_matrix(const BrickLattice&);
template HexMatrix<double> make_hex_matrix(const BrickLattice&);
template double apply(const HexOperator&, const HexMatrix<float>&, const AlignedArray<float>&, AlignedArray<float>&);
template double apply(const HexOperator&, const HexMatrix<float>&, const AlignedArray<double>&, AlignedArray<double>&);
template double apply(const HexOperator&, const HexMatrix<double>&, const AlignedArray<double>&, AlignedArray<double>&);
template double residual(const HexOperator&, const HexMatrix<float>&, const AlignedArray<float>&,
                         const AlignedArray<float>&, AlignedArray<float>&);
template double residual(const HexOperator&, const HexMatrix<float>&, const AlignedArray<double>&,
                         const AlignedArray<double>&, AlignedArray<float>&);
template double residual(const HexOperator&, const HexMatrix<double>&, const AlignedArray<double>&,
                         const AlignedArray<double>&, AlignedArray<float>&);
template void force(const HexOperator&, const HexMatrix<float>&, const AlignedArray<double>&,
                    const AlignedArray<double>&, AlignedArray<double>&);
template void force(const HexOperator&, const HexMatrix<double>&, const AlignedArray<double>&,
                    const AlignedArray<double>&, AlignedArray<double>&);

}  // namespace umax
