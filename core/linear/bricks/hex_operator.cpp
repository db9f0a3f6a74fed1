#include "core/linear/bricks/hex_operator.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "core/element/rotation.h"
#include "core/linear/bricks/multigrid_kernel.h"

namespace umax {
namespace {

double run(const HexOperator& op, const HexMatrix<float>& matrix, Epilogue epilogue, const Sweep<float, float>& sweep) {
  return run(op, op.float_constants, matrix, hex_kernels(op.instruction_set).sweeps[int(epilogue)], sweep);
}

}  // namespace

HexOperator make_hex_operator(BrickLattice lattice, const HexShape& box, InstructionSet instruction_set) {
  assert(is_supported(instruction_set));
  const HexConstants<double> constants = make_hex_constants(box);
  return {std::move(lattice), constants, to_float(constants), instruction_set};
}

double apply(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& x,
             AlignedArray<float>& out) {
  Sweep<float, float> sweep;
  sweep.x = x.data();
  sweep.out = out.data();
  return run(op, matrix, Epilogue::apply, sweep);
}

double residual(const HexOperator& op, const HexMatrix<float>& matrix, const AlignedArray<float>& b,
                const AlignedArray<float>& x, AlignedArray<float>& out) {
  Sweep<float, float> sweep;
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

}  // namespace umax
