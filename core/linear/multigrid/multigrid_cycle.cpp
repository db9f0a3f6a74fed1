#include "core/linear/multigrid/multigrid_cycle.h"

namespace umax {
namespace {

constexpr int coarsest_sweeps = 4;  // of the smoother, where the last level is not factored

// Both return which of the two iterates is current, they alternate.
int smooth(MultigridLevel& level, const AlignedArray<float>& b, int current, double& product) {
  for (const ChebyshevStep& step : level.steps) {
    product = chebyshev(level.op, level.matrix, level.inverse, step, b, level.x[current], level.x[1 - current]);
    current = 1 - current;
  }
  return current;
}

int smooth_from_zero(MultigridLevel& level, const AlignedArray<float>& b, double& product) {
  jacobi_from_zero(level, b, level.steps[0].gain);
  int current = 0;
  for (std::size_t n = 1; n < level.steps.size(); ++n) {
    ChebyshevStep step = level.steps[n];
    if (n == 1) step.momentum = 0;  // the iterate before is zero
    product = chebyshev(level.op, level.matrix, level.inverse, step, b, level.x[current], level.x[1 - current]);
    current = 1 - current;
  }
  return current;
}

AlignedArray<float>& solve_dense(Multigrid& multigrid, const AlignedArray<float>& b) {
  VectorXd x = dense_values(multigrid, b);
  solve_lower(multigrid.dense, x);
  solve_upper(multigrid.dense, x);
  return set_dense_values(x, multigrid);
}

}  // namespace

VectorXd dense_values(const Multigrid& multigrid, const AlignedArray<float>& vector) {
  const std::vector<int>& slots = multigrid.dense_slots;
  VectorXd values;
  from_bricks(slots, vector, values);
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (!(multigrid.levels.back().matrix.diagonal[slots[i]] > 0)) values.segment<3>(3 * Eigen::Index(i)).setZero();
  return values;
}

AlignedArray<float>& set_dense_values(const VectorXd& values, Multigrid& multigrid) {
  AlignedArray<float>& x = multigrid.levels.back().x[0];
  to_bricks(multigrid.dense_slots, values, x);
  return x;
}

void jacobi_from_zero(MultigridLevel& level, const AlignedArray<float>& b, float gain) {
  const BlockJacobi task{level.lattice().node_masks.data(), level.inverse.data(), b.data(), gain, level.x[0].data()};
  for_each_block(level.lattice(), [&](int first, int last) { kernels_of(level).block_jacobi(task, first, last); });
}

void restrict_residual(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, int current) {
  MultigridLevel &level = multigrid.levels[depth], &coarse = multigrid.levels[depth + 1];
  residual(level.op, level.matrix, b, level.x[current], level.x[1 - current]);
  restrict_vector(level, level.x[1 - current], coarse, coarse.b);
}

void prolong(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& correction, int current) {
  MultigridLevel& level = multigrid.levels[depth];
  const Transfer transfer = transfer_between(level, multigrid.levels[depth + 1]);
  for_each_block(level.lattice(), [&](int first, int last) {
    kernels_of(level).prolong(transfer, correction.data(), level.matrix.diagonal.data(), level.x[current].data(), first,
                              last);
  });
}

AlignedArray<float>& v_cycle(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, double& product) {
  MultigridLevel& level = multigrid.levels[depth];
  if (depth + 1 == multigrid.levels.size()) {
    if (multigrid.has_dense) return solve_dense(multigrid, b);
    int current = smooth_from_zero(level, b, product);
    for (int sweep = 1; sweep < coarsest_sweeps; ++sweep) current = smooth(level, b, current, product);
    return level.x[current];
  }
  int current = smooth_from_zero(level, b, product);
  restrict_residual(multigrid, depth, b, current);
  prolong(multigrid, depth, v_cycle(multigrid, depth + 1, multigrid.levels[depth + 1].b, product), current);
  current = smooth(level, b, current, product);
  return level.x[current];
}

}  // namespace umax
