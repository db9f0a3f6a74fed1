#include "core/hex_operator.h"

#include <cassert>
#include <type_traits>

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
  sweep.bricks = op.lattice->bricks.data();
  if constexpr (std::is_same_v<T, float>)
    sweep.constants = &op.float_constants;
  else
    sweep.constants = &op.constants;
  sweep.frames = matrix.frames.data();
  sweep.diagonal = matrix.diagonal.data();
  const SweepFunction<T, S> function = sweep_function<T, S>(hex_kernels(op.instruction_set), epilogue);
  return for_each_column(*op.lattice, [&](int first, int last) { return function(sweep, first, last); });
}

}  // namespace

template <class S>
HexMatrix<S> make_hex_matrix(const BrickLattice& lattice) {
  return {AlignedArray<S>(lattice.num_slots() * frame_components), AlignedArray<S>(lattice.num_slots())};
}

HexOperator make_hex_operator(const BrickLattice& lattice, const HexShape& box, InstructionSet instruction_set) {
  assert(is_supported(instruction_set));
  const HexConstants<double> constants = make_hex_constants(box);
  return {&lattice, constants, to_float(constants), instruction_set};
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

template <class T>
void to_bricks(const std::vector<int>& slots, const VectorXd& values, AlignedArray<T>& bricks) {
  for (std::size_t node = 0; node < slots.size(); ++node)
    for (int c = 0; c < 3; ++c)
      bricks[slot_offset(slots[node], vector_components) + c * brick_lanes] = T(values[3 * Eigen::Index(node) + c]);
}

template <class T>
void from_bricks(const std::vector<int>& slots, const AlignedArray<T>& bricks, VectorXd& values) {
  values.resize(3 * Eigen::Index(slots.size()));
  for (std::size_t node = 0; node < slots.size(); ++node)
    for (int c = 0; c < 3; ++c)
      values[3 * Eigen::Index(node) + c] =
          double(bricks[slot_offset(slots[node], vector_components) + c * brick_lanes]);
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
template void to_bricks(const std::vector<int>&, const VectorXd&, AlignedArray<float>&);
template void to_bricks(const std::vector<int>&, const VectorXd&, AlignedArray<double>&);
template void from_bricks(const std::vector<int>&, const AlignedArray<float>&, VectorXd&);
template void from_bricks(const std::vector<int>&, const AlignedArray<double>&, VectorXd&);

}  // namespace umax
