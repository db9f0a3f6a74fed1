#include "tests/support/double_operator.h"

#include <type_traits>

#include "tests/support/double_kernels.h"

namespace umax {
namespace portable {
extern const test::DoubleKernels double_kernels;
}  // namespace portable
#ifdef UMAX_X86_KERNELS
namespace avx2 {
extern const test::DoubleKernels double_kernels;
}  // namespace avx2
namespace avx512 {
extern const test::DoubleKernels double_kernels;
}  // namespace avx512
#endif
}  // namespace umax

namespace umax::test {
namespace {

const DoubleKernels& kernels_of(InstructionSet set) {
#ifdef UMAX_X86_KERNELS
  if (set == InstructionSet::avx512) return avx512::double_kernels;
  if (set == InstructionSet::avx2) return avx2::double_kernels;
#endif
  (void)set;
  return portable::double_kernels;
}

}  // namespace

template <class S>
double apply(const HexOperator& op, const HexMatrix<S>& matrix, const AlignedArray<double>& x,
             AlignedArray<double>& out) {
  Sweep<double, S> sweep;
  sweep.x = x.data();
  sweep.out = out.data();
  const DoubleKernels& kernels = kernels_of(op.instruction_set);
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
  const DoubleKernels& kernels = kernels_of(op.instruction_set);
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
