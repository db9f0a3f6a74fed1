#include "core/minimum_residual.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace umax {
namespace {

// calls body(first, end) for values of node vectors, in parallel
template <class Body>
double over_values(const BrickLattice& lattice, const Body& body) {
  constexpr std::size_t brick_values = brick_slots * vector_components;
  return for_each_column(lattice, [&](int first, int last) { return body(first * brick_values, last * brick_values); });
}

// a x + b y + c z -> z, for y and z that may be the same
void combine(const BrickLattice& lattice, float a, const AlignedArray<float>& x, float b, const AlignedArray<float>& y,
             float c, AlignedArray<float>& z) {
  const float *from_x = x.data(), *from_y = y.data();
  float* to = z.data();
  over_values(lattice, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) to[i] = a * from_x[i] + b * from_y[i] + c * to[i];
    return 0.0;
  });
}

void scale(const BrickLattice& lattice, float a, const AlignedArray<float>& x, AlignedArray<float>& out) {
  const float* from = x.data();
  float* to = out.data();
  over_values(lattice, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) to[i] = a * from[i];
    return 0.0;
  });
}

}  // namespace

MinimumResidualWorkspace make_residual_workspace(const Multigrid& multigrid) {
  const std::size_t size = multigrid.levels.front().lattice.num_slots() * vector_components;
  MinimumResidualWorkspace workspace;
  for (AlignedArray<float>& v : workspace.residuals) v = AlignedArray<float>(size);
  for (AlignedArray<float>& v : workspace.directions) v = AlignedArray<float>(size);
  workspace.step = AlignedArray<float>(size);
  return workspace;
}

MinimumResidualReport solve(Multigrid& multigrid, const HexTerms& terms, const MinimumResidualOptions& options,
                            const AlignedArray<float>& b, const VectorXd& c, MinimumResidualWorkspace& workspace,
                            AlignedArray<float>& x, VectorXd& y) {
  MultigridLevel& level = multigrid.levels.front();
  const BrickLattice& lattice = level.lattice;
  const Eigen::Index num_terms = Eigen::Index(terms.vectors.size());
  // Lanczos vectors before, now and next, and search directions likewise: each the nodes' part and the terms'
  AlignedArray<float>*r_before = &workspace.residuals[0], *r = &workspace.residuals[1],
  *r_next = &workspace.residuals[2];
  AlignedArray<float>*w_before = &workspace.directions[0], *w = &workspace.directions[1],
  *w_next = &workspace.directions[2];
  AlignedArray<float>& v = workspace.step;
  VectorXd q_before = VectorXd::Zero(num_terms), q = c, q_next = q_before, u = q_before, products = q_before;
  VectorXd d_before = q_before, d = q_before, d_next = q_before;
  for (AlignedArray<float>* zero : {r_before, w_before, w, &x}) std::fill(zero->begin(), zero->end(), 0.f);
  std::copy(b.begin(), b.end(), r->begin());
  y = q_before;

  MinimumResidualReport report;
  double product = 0;
  const AlignedArray<float>* z = &precondition(multigrid, *r, product);
  VectorXd zq;  // of the terms' part
  precondition(terms, q, zq);
  product += q.dot(zq);
  const double first = std::sqrt(product);
  if (!(first > 0)) return report;
  double beta = first, beta_before = 0, left = first;
  double delta_bar = 0, epsilon = 0, cosine = -1, sine = 0;
  report.residual = 1;
  while (report.residual > options.tolerance && report.iterations < options.max_iterations) {
    ++report.iterations;
    scale(lattice, float(1 / beta), *z, v);
    u = zq / beta;
    double alpha = apply(level.op, level.matrix, v, *r_next);
    if (num_terms > 0) {
      multiply(terms, v, products);
      add(terms, u, *r_next);
      q_next = products - u;
      alpha += u.dot(products) + u.dot(q_next);
    }
    const double keep = beta_before > 0 ? beta / beta_before : 0;
    combine(lattice, float(-keep), *r_before, float(-alpha / beta), *r, 1, *r_next);
    q_next -= keep * q_before + alpha / beta * q;
    std::swap(r_before, r), std::swap(r, r_next);
    q_before.swap(q), q.swap(q_next);

    z = &precondition(multigrid, *r, product);
    if (num_terms > 0) {
      precondition(terms, q, zq);
      product += q.dot(zq);
    }
    beta_before = beta;
    beta = std::sqrt(std::max(0.0, product));

    const double epsilon_before = epsilon, delta = cosine * delta_bar + sine * alpha;
    const double gamma_bar = sine * delta_bar - cosine * alpha;
    epsilon = sine * beta;
    delta_bar = -cosine * beta;
    const double gamma = std::hypot(gamma_bar, beta);
    cosine = gamma_bar / gamma;
    sine = beta / gamma;
    const double stride = cosine * left;
    left *= sine;
    // w_next = (v - epsilon w_before - delta w) / gamma,  x += stride w_next
    {
      const float *from_v = v.data(), *from_before = w_before->data(), *from_w = w->data();
      float *to = w_next->data(), *to_x = x.data();
      const float a = float(1 / gamma), e = float(-epsilon_before / gamma), f = float(-delta / gamma),
                  t = float(stride);
      over_values(lattice, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          to[i] = a * from_v[i] + e * from_before[i] + f * from_w[i];
          to_x[i] += t * to[i];
        }
        return 0.0;
      });
    }
    d_next = (u - epsilon_before * d_before - delta * d) / gamma;
    y += stride * d_next;
    std::swap(w_before, w), std::swap(w, w_next);
    d_before.swap(d), d.swap(d_next);
    report.residual = left / first;
  }
  return report;
}

}  // namespace umax
