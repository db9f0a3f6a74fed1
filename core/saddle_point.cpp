#include "core/saddle_point.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr double first_gamma = 4;   // smaller: fewer iterations where the multigrid is as good as that
constexpr double last_gamma = 1e4;  // beyond it rounding is all that is left

// calls body(first, end), which returns a double, for values of node vectors in parallel; the sum of the results
template <class Body>
double over_values(const BrickLattice& lattice, const Body& body) {
  constexpr std::size_t brick_values = brick_slots * vector_components;
  return for_each_column(lattice, [&](int first, int last) { return body(first * brick_values, last * brick_values); });
}

void scale(const BrickLattice& lattice, float factor, const AlignedArray<float>& x, AlignedArray<float>& out) {
  over_values(lattice, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) out[i] = factor * x[i];
    return 0.0;
  });
}

// the direction from the residual's image and the direction before; force = A d
void turn(const BrickLattice& lattice, float beta, SaddlePoint& w) {
  const float *solved = w.solved.data(), *applied = w.applied.data();
  float *d = w.direction.data(), *Ad = w.direction_applied.data(), *force = w.force.data();
  over_values(lattice, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      d[i] = solved[i] + beta * d[i];
      force[i] = Ad[i] = applied[i] + beta * Ad[i];
    }
    return 0.0;
  });
}

// x and what belongs to it, along the direction; image: B force
void advance(const BrickLattice& lattice, float alpha, float gamma, const AlignedArray<float>& image, SaddlePoint& w) {
  const float *d = w.direction.data(), *force = w.force.data(), *from = image.data();
  float *x = w.x.data(), *r = w.residual.data(), *solved = w.solved.data();
  const float back = alpha * gamma;
  over_values(lattice, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      x[i] += alpha * d[i];
      r[i] -= alpha * force[i];
      solved[i] -= back * from[i];
    }
    return 0.0;
  });
}

// S^-1 of what the terms have, nearly. Uses w.force and the first level's first iterate.
VectorXd precondition_terms(Multigrid& multigrid, const HexTerms& terms, const TermCoupling& coupling,
                            const VectorXd& values, SaddlePoint& w) {
  if (!coupling.exists) return precondition(terms, values);
  MultigridLevel& level = multigrid.levels.front();
  const auto solve_blocks = [&](AlignedArray<float>& x) {
    for_each_column(level.lattice, [&](int first, int last) {
      multigrid_kernels(level.op.instruction_set)
          .block_jacobi(level.inverse.data(), x.data(), 1, x.data(), first, last);
      return 0.0;
    });
  };
  const VectorXd solved = solve(coupling.factor, values);
  std::fill(w.force.begin(), w.force.end(), 0.f);
  add(terms, solved, w.force);
  solve_blocks(w.force);
  apply(level.op, level.matrix, w.force, level.x[0]);
  solve_blocks(level.x[0]);
  VectorXd products(values.size());
  multiply(terms, level.x[0], products);
  return solve(coupling.factor, solved + products);
}

}  // namespace

SaddlePoint make_saddle_point(const Multigrid& multigrid) {
  const std::size_t size = multigrid.levels.front().lattice.num_slots() * vector_components;
  SaddlePoint point;
  for (AlignedArray<float>* v : {&point.x, &point.residual, &point.solved, &point.applied, &point.direction,
                                 &point.direction_applied, &point.force})
    *v = AlignedArray<float>(size);
  return point;
}

void begin(const VectorXd& c, SaddlePoint& point) {
  for (AlignedArray<float>* zero : {&point.x, &point.residual}) std::fill(zero->begin(), zero->end(), 0.f);
  point.y = VectorXd::Zero(c.size());
  point.c = point.term_residual = c;
  point.gamma = first_gamma;
  point.largest_norm = 0;
}

SaddlePointReport solve(Multigrid& multigrid, const HexTerms& terms, const TermCoupling& coupling,
                        const SaddlePointOptions& options, SaddlePoint& point) {
  MultigridLevel& level = multigrid.levels.front();
  const BrickLattice& lattice = level.lattice;
  SaddlePoint& w = point;
  VectorXd& s = w.term_residual;  // c - G^T x + y
  for (AlignedArray<float>* zero : {&w.direction, &w.direction_applied}) std::fill(zero->begin(), zero->end(), 0.f);
  // the direction of the terms, G^T of what the nodes have
  VectorXd e = VectorXd::Zero(s.size()), of_solved = e, of_direction = e, of_image = e;

  double product = 0, started = 0, before = 0;
  bool fresh = false;
  const auto restart = [&] {  // from the residual, along it
    scale(lattice, float(w.gamma), precondition(multigrid, w.residual, product), w.solved);
    multiply(terms, w.solved, of_solved);
    before = 0;
    fresh = true;
  };
  const auto enlarge = [&] {
    w.gamma *= 2;
    restart();
    return w.gamma <= last_gamma;
  };
  restart();
  SaddlePointReport report;
  while (true) {
    const double applied = apply(level.op, level.matrix, w.solved, w.applied);
    const VectorXd of_terms = of_solved - s;
    const VectorXd preconditioned = precondition_terms(multigrid, terms, coupling, of_terms, w);
    const double squared = applied - dot(lattice, w.residual, w.solved) + of_terms.dot(preconditioned);
    if (squared == 0) {
      report.residual = 0;
      break;
    }
    if (!(squared > 0)) {  // A0 is not smaller than A, or rounding has parted the residual from its image
      if (!fresh)
        restart();
      else if (!enlarge())
        break;
      continue;
    }
    const double norm = std::sqrt(squared);
    if (started == 0) started = norm;
    w.largest_norm = std::max(w.largest_norm, started);
    report.residual = norm / w.largest_norm;
    if (report.residual <= options.tolerance || norm <= options.reduction * started) break;
    if (report.iterations == options.max_iterations) break;
    ++report.iterations;
    const double beta = before > 0 ? squared / before : 0;
    before = squared;
    fresh = false;
    turn(lattice, float(beta), w);
    e = preconditioned + beta * e;
    of_direction = of_solved + beta * of_direction;
    if (e.size() > 0) add(terms, e, w.force);
    const AlignedArray<float>& image = precondition(multigrid, w.force, product);
    multiply(terms, image, of_image);
    const double curvature =
        w.gamma * product - dot(lattice, w.direction, w.force) - e.dot(of_direction) + e.squaredNorm();
    if (!(curvature > 0)) {
      if (!enlarge()) break;
      continue;
    }
    const double alpha = squared / curvature;
    advance(lattice, float(alpha), float(w.gamma), image, w);
    w.y += alpha * e;
    of_solved -= alpha * w.gamma * of_image;
    s -= alpha * (of_direction - e);
  }
  return report;
}

}  // namespace umax
