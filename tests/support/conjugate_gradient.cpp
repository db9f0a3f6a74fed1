#include "tests/support/conjugate_gradient.h"

#include <algorithm>
#include <cmath>

#include "tests/support/double_operator.h"

namespace umax::test {
namespace {

constexpr std::size_t brick_values = brick_slots * vector_components;
constexpr double replacement = 1e-3;  // fall of the residual after which it is computed anew

// x += step, step = 0, residual = b - A x; returns its norm
double replace_residual(const MultigridLevel& level, const HexMatrix<double>* exact, const AlignedArray<double>& b,
                        ConjugateGradientWorkspace& workspace, AlignedArray<double>& x) {
  for_each_column(level.lattice(), [&](int first, int last) {
    for (std::size_t i = first * brick_values; i < last * brick_values; ++i) {
      x[i] += double(workspace.step[i]);
      workspace.step[i] = 0;
    }
    return 0.0;
  });
  return std::sqrt(exact ? residual(level.op, *exact, b, x, workspace.residual)
                         : residual(level.op, level.matrix, b, x, workspace.residual));
}

// x += alpha p, r -= alpha q; returns r . r
double advance(const BrickLattice& lattice, const AlignedArray<float>& p, const AlignedArray<float>& q, float alpha,
               AlignedArray<float>& x, AlignedArray<float>& r) {
  return for_each_column(lattice, [&](int first, int last) {
    double total = 0;
    for (int brick = first; brick < last; ++brick) {
      float sums[brick_lanes] = {};
      for (std::size_t i = brick * brick_values; i < (brick + 1) * brick_values; i += brick_lanes) {
        float next[brick_lanes];
        for (int lane = 0; lane < brick_lanes; ++lane) x[i + lane] += alpha * p[i + lane];
        for (int lane = 0; lane < brick_lanes; ++lane) next[lane] = r[i + lane] - alpha * q[i + lane];
        for (int lane = 0; lane < brick_lanes; ++lane) sums[lane] += next[lane] * next[lane];
        std::copy_n(next, brick_lanes, &r[i]);
      }
      for (const float sum : sums) total += double(sum);
    }
    return total;
  });
}

}  // namespace

ConjugateGradientWorkspace make_workspace(const Multigrid& multigrid) {
  const std::size_t size = multigrid.levels.front().lattice().num_slots() * vector_components;
  return {AlignedArray<float>(size), AlignedArray<float>(size), AlignedArray<float>(size)};
}

ConjugateGradientReport solve(Multigrid& multigrid, const HexMatrix<double>* exact,
                              const ConjugateGradientOptions& options, const AlignedArray<double>& b,
                              ConjugateGradientWorkspace& workspace, AlignedArray<double>& x) {
  MultigridLevel& level = multigrid.levels.front();
  const MultigridKernels& kernels = multigrid_kernels(level.op.instruction_set);
  auto& [step, r, p] = workspace;
  ConjugateGradientReport report;
  const double wanted = options.tolerance * std::sqrt(dot(level.lattice(), b, b));
  std::fill(step.begin(), step.end(), 0.f);
  std::fill(x.begin(), x.end(), 0.0);
  std::transform(b.begin(), b.end(), r.begin(), [](double value) { return float(value); });
  double true_norm = wanted / options.tolerance, rz_before = 0;
  while (true_norm > wanted && report.iterations < options.max_iterations) {
    ++report.iterations;
    double rz = 0;
    const AlignedArray<float>& z = precondition(multigrid, r, rz);
    const float beta = rz_before > 0 ? float(rz / rz_before) : 0.f;
    rz_before = rz;
    for_each_column(level.lattice(), [&](int first, int last) {
      kernels.turn(z.data(), beta, p.data(), first, last);
      return 0.0;
    });
    AlignedArray<float>& q = level.x[0];  // the preconditioner is done with it
    const float alpha = float(rz / apply(level.op, level.matrix, p, q));
    const double norm = std::sqrt(advance(level.lattice(), p, q, alpha, step, r));
    if (norm <= std::max(wanted, replacement * true_norm)) true_norm = replace_residual(level, exact, b, workspace, x);
  }
  if (report.iterations == options.max_iterations) true_norm = replace_residual(level, exact, b, workspace, x);
  report.residual = true_norm > 0 ? true_norm * options.tolerance / wanted : 0;
  report.converged = true_norm <= wanted;
  return report;
}

}  // namespace umax::test
