#include "tests/support/matrix_product.h"

namespace umax::test {

VectorXd multiply(const SystemMatrix& matrix, const VectorXd& x) {
  const auto by_node = [&](int unknown) { return 3 * matrix.order[unknown / 3] + unknown % 3; };
  VectorXd y = VectorXd::Zero(x.size());
  for (int column = 0; column < matrix.num_unknowns(); ++column)
    for (int k = matrix.column_starts[column]; k < matrix.column_starts[column + 1]; ++k) {
      const int i = by_node(matrix.row_indices[k]), j = by_node(column);
      y[i] += matrix.values[k] * x[j];
      if (i != j) y[j] += matrix.values[k] * x[i];
    }
  return y;
}

}  // namespace umax::test
