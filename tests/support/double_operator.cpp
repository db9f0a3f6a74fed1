#include "tests/support/double_operator.h"

#include <type_traits>

#include "core/base/kernel_choice.h"
#include "tests/support/double_kernels.h"

namespace umax::test {

template <class S>
double apply(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& x,
             AlignedArray<double>& out) {
  Sweep<double, S> sweep;
  sweep.x = x.data();
  sweep.out = out.data();
  const DoubleKernels& kernels = chosen_kernels<DoubleKernels>(op.instruction_set);
  if constexpr (std::is_same_v<S, float>)
    return run(op, op.constants, matrix, kernels.mixed_apply, sweep);
  else
    return run(op, op.constants, matrix, kernels.apply, sweep);
}

template <class S>
double residual(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& b,
                const AlignedArray<double>& x, AlignedArray<float>& out) {
  Sweep<double, S> sweep;
  sweep.x = x.data();
  sweep.b = b.data();
  sweep.out = out.data();
  const DoubleKernels& kernels = chosen_kernels<DoubleKernels>(op.instruction_set);
  if constexpr (std::is_same_v<S, float>)
    return run(op, op.constants, matrix, kernels.mixed_residual, sweep);
  else
    return run(op, op.constants, matrix, kernels.residual, sweep);
}

template double apply(const HexOperator&, const HexMatrix<float>&, const AlignedArray<double>&, AlignedArray<double>&);
template double apply(const HexOperator&, const HexMatrix<double>&, const AlignedArray<double>&, AlignedArray<double>&);
template double residual(const HexOperator&, const HexMatrix<float>&, const AlignedArray<double>&,
                         const AlignedArray<double>&, AlignedArray<float>&);
template double residual(const HexOperator&, const HexMatrix<double>&, const AlignedArray<double>&,
                         const AlignedArray<double>&, AlignedArray<float>&);

}  // namespace umax::test
