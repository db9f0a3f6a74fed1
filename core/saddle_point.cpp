#include "core/saddle_point.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace umax {
namespace {

using Direction = SaddlePoint::Direction;

// x += factor d, of node vectors
void add(const BrickLattice& lattice, double factor, const AlignedArray<float>& d, AlignedArray<float>& x) {
  constexpr std::size_t brick_values = brick_slots * vector_components;
  const float f = float(factor);
  for_each_column(lattice, [&](int first, int last) {
    for (std::size_t i = first * brick_values; i < last * brick_values; ++i) x[i] += f * d[i];
    return 0.0;
  });
}

void scale(const BrickLattice& lattice, double factor, const AlignedArray<float>& x, AlignedArray<float>& out) {
  constexpr std::size_t brick_values = brick_slots * vector_components;
  const float f = float(factor);
  for_each_column(lattice, [&](int first, int last) {
    for (std::size_t i = first * brick_values; i < last * brick_values; ++i) out[i] = f * x[i];
    return 0.0;
  });
}

// of what is left over of both kinds
double product(const BrickLattice& lattice, double weight, const AlignedArray<float>& image, const VectorXd& term_image,
               const Direction& direction) {
  return dot(lattice, image, direction.image) + weight * term_image.dot(direction.term_image);
}

double residual_norm(const BrickLattice& lattice, double weight, const SaddlePoint& point) {
  return std::sqrt(dot(lattice, point.residual, point.residual) + weight * point.term_residual.squaredNorm());
}

// the part of the residual that a direction removes
void advance(const BrickLattice& lattice, double weight, const Direction& d, SaddlePoint& point) {
  const double along = product(lattice, weight, point.residual, point.term_residual, d);
  add(lattice, along, d.x, point.x);
  add(lattice, -along, d.image, point.residual);
  point.y += along * d.y;
  point.term_residual -= along * d.term_image;
}

}  // namespace

SaddlePoint make_saddle_point(const Multigrid& multigrid) {
  const std::size_t size = multigrid.levels.front().lattice.num_slots() * vector_components;
  SaddlePoint point;
  for (AlignedArray<float>* v : {&point.x, &point.residual}) *v = AlignedArray<float>(size);
  for (Direction& d : point.directions) {
    d.x = AlignedArray<float>(size);
    d.image = AlignedArray<float>(size);
  }
  return point;
}

void begin(const VectorXd& c, SaddlePoint& point) {
  for (AlignedArray<float>* zero : {&point.x, &point.residual}) std::fill(zero->begin(), zero->end(), 0.f);
  point.y = VectorXd::Zero(c.size());
  point.c = point.term_residual = c;
  point.largest_error = 0;
  point.num_directions = 0;
}

SaddlePointReport solve(Multigrid& multigrid, TermMultigrid& coupled, const SaddlePointOptions& options,
                        SaddlePoint& point) {
  MultigridLevel& level = multigrid.levels.front();
  const BrickLattice& lattice = level.lattice;
  const HexTerms& terms = coupled.levels.front().terms;
  const double weight = coupled.weight;
  const int most = int(point.directions.size());
  for (int i = std::max(0, point.num_directions - most + 1); point.pushed && i < point.num_directions; ++i)
    advance(lattice, weight, point.directions[i % most], point);
  point.pushed = false;
  SaddlePointReport report;
  double norm = residual_norm(lattice, weight, point), started = 0;
  while (norm > 0) {
    VectorXd y;
    const AlignedArray<float>& x = precondition(multigrid, coupled, point.residual, point.term_residual, y);
    Direction& d = point.directions[point.num_directions % most];
    scale(lattice, 1, x, d.x);
    double error = std::sqrt(std::max(0.0, apply(level.op, level.matrix, d.x, d.image)));
    if (started == 0) started = error;
    point.largest_error = std::max(point.largest_error, error);
    const auto is_small = [&] {
      report.error = point.largest_error > 0 ? error / point.largest_error : 0;
      return !(error > 0) || report.error <= options.tolerance || error <= options.reduction * started;
    };
    if (is_small() || report.iterations == options.max_iterations) break;
    d.y = y;
    d.term_image.resize(y.size());
    if (y.size() > 0) {
      multiply(terms, d.x, d.term_image);
      d.term_image -= d.y;
      add(terms, d.y, d.image);
    }
    for (int i = std::max(0, point.num_directions - most + 1); i < point.num_directions; ++i) {
      const Direction& before = point.directions[i % most];
      const double share = product(lattice, weight, d.image, d.term_image, before);
      add(lattice, -share, before.x, d.x);
      add(lattice, -share, before.image, d.image);
      d.y -= share * before.y;
      d.term_image -= share * before.term_image;
    }
    const double size = std::sqrt(product(lattice, weight, d.image, d.term_image, d));
    if (!(size > 0) || !std::isfinite(size)) break;
    for (AlignedArray<float>* v : {&d.x, &d.image}) scale(lattice, 1 / size, *v, *v);
    d.y /= size;
    d.term_image /= size;
    ++point.num_directions;
    ++report.iterations;
    advance(lattice, weight, d, point);
    const double before = std::exchange(norm, residual_norm(lattice, weight, point));
    error *= norm / before;  // as far as can be told without another cycle
    if (is_small()) break;
  }
  return report;
}

}  // namespace umax
