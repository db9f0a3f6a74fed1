#include "core/linear/saddle/saddle_point.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

using Direction = SaddlePoint::Direction;

constexpr int most_directions = int(std::tuple_size_v<decltype(SaddlePoint::directions)>);
constexpr double stuck_share = 0.98;  // of the residual's norm, from which its own direction leads nowhere
constexpr Eigen::Index bricks_per_block = 8, terms_per_block = 4096;
constexpr int line_values = brick_lanes * vector_components;

using Sums = std::array<double, most_directions>;
using LaneSums = std::array<double, brick_lanes / 2>;  // that are added up at the end of a block

// Calls body(begin, end, sums to add to) for blocks of [0, count), in parallel; the sums, in a fixed order.
template <class Body>
Sums sum_over_blocks(Eigen::Index count, Eigen::Index grain, const Body& body) {
  std::vector<Sums> of_blocks(std::size_t((count + grain - 1) / grain), Sums{});
  parallel_blocks(count, grain, [&](Eigen::Index begin, Eigen::Index end) {
    body(begin, end, of_blocks[std::size_t(begin / grain)]);
  });
  Sums total{};
  for (const Sums& sums : of_blocks)
    for (int k = 0; k < most_directions; ++k) total[k] += sums[k];
  return total;
}

// Calls body(place of the first value, sums to add to) for the lines that have nodes.
template <class Body>
Sums sum_over_lines(const BrickLattice& lattice, const Body& body) {
  const auto of_bricks = [&](Eigen::Index begin, Eigen::Index end, Sums& sums) {
    std::array<LaneSums, most_directions> lanes{};
    for (Eigen::Index b = begin; b < end; ++b)
      for (std::uint64_t lines = lattice.bricks[b].node_lines; lines != 0; lines &= lines - 1)
        body((std::size_t(b) * brick_lines + std::size_t(std::countr_zero(lines))) * line_values, lanes);
    for (int k = 0; k < most_directions; ++k) sums[k] += std::accumulate(lanes[k].begin(), lanes[k].end(), 0.0);
  };
  return sum_over_blocks(Eigen::Index(lattice.bricks.size()), bricks_per_block, of_bricks);
}

// Calls body(of(values), sums to add to) for blocks of the terms, `of` taking the block's part of what is given per
// term.
template <class Body>
Sums sum_over_terms(Eigen::Index count, const Body& body) {
  const auto of_terms = [&](Eigen::Index begin, Eigen::Index end, Sums& sums) {
    body([=](auto& values) { return values.segment(begin, end - begin); }, sums);
  };
  return sum_over_blocks(count, terms_per_block, of_terms);
}

void add_product(const float* a, const float* b, LaneSums& sums) {
  float lanes[brick_lanes] = {};
  for (int i = 0; i < line_values; i += brick_lanes)
    for (int lane = 0; lane < brick_lanes; ++lane) lanes[lane] += a[i + lane] * b[i + lane];
  for (std::size_t lane = 0; lane < sums.size(); ++lane)
    sums[lane] += double(lanes[lane]) + double(lanes[lane + sums.size()]);
}

void add_line(float factor, const float* a, float* to) {
  for (int i = 0; i < line_values; ++i) to[i] += factor * a[i];
}

// what of an image each of the directions' images makes up; weight: of terms
Sums shares_of(const BrickLattice& lattice, double weight, const std::vector<const Direction*>& directions,
               const AlignedArray<float>& image, const VectorXd& term_image) {
  Sums shares = sum_over_lines(lattice, [&](std::size_t at, auto& sums) {
    for (std::size_t k = 0; k < directions.size(); ++k) add_product(&image[at], &directions[k]->image[at], sums[k]);
  });
  const Sums of_terms = sum_over_terms(term_image.size(), [&](const auto& of, Sums& sums) {
    for (std::size_t k = 0; k < directions.size(); ++k) sums[k] += of(term_image).dot(of(directions[k]->term_image));
  });
  for (std::size_t k = 0; k < directions.size(); ++k)
    shares[k] = (shares[k] + weight * of_terms[k]) / directions[k]->square;
  return shares;
}

// the directions that are kept, but for the place of the next one
std::vector<const Direction*> kept(const SaddlePoint& point) {
  std::vector<const Direction*> directions;
  for (int i = std::max(0, point.num_directions - most_directions + 1); i < point.num_directions; ++i)
    directions.push_back(&point.directions[i % most_directions]);
  return directions;
}

// makes the direction's image orthogonal to those of the others
void orthogonalise(const BrickLattice& lattice, double weight, const std::vector<const Direction*>& others,
                   Direction& d) {
  const Sums shares = shares_of(lattice, weight, others, d.image, d.term_image);
  d.square = sum_over_lines(lattice, [&](std::size_t at, auto& sums) {
    for (std::size_t k = 0; k < others.size(); ++k) {
      add_line(float(-shares[k]), &others[k]->x[at], &d.x[at]);
      add_line(float(-shares[k]), &others[k]->image[at], &d.image[at]);
    }
    add_product(&d.image[at], &d.image[at], sums[0]);
  })[0];
  d.square += weight * sum_over_terms(d.y.size(), [&](const auto& of, Sums& sums) {
                for (std::size_t k = 0; k < others.size(); ++k) {
                  of(d.y) -= shares[k] * of(others[k]->y);
                  of(d.term_image) -= shares[k] * of(others[k]->term_image);
                }
                sums[0] += of(d.term_image).squaredNorm();
              })[0];
}

// Goes along directions with orthogonal images as far as reduces the residual most. Returns the residual's norm.
double advance(const BrickLattice& lattice, double weight, const std::vector<const Direction*>& directions,
               SaddlePoint& point) {
  const Sums along = shares_of(lattice, weight, directions, point.residual, point.term_residual);
  const double square = sum_over_lines(lattice, [&](std::size_t at, auto& sums) {
    for (std::size_t k = 0; k < directions.size(); ++k) {
      add_line(float(along[k]), &directions[k]->x[at], &point.x[at]);
      add_line(float(-along[k]), &directions[k]->image[at], &point.residual[at]);
    }
    add_product(&point.residual[at], &point.residual[at], sums[0]);
  })[0];
  const double term_square = sum_over_terms(point.y.size(), [&](const auto& of, Sums& sums) {
    for (std::size_t k = 0; k < directions.size(); ++k) {
      of(point.y) += along[k] * of(directions[k]->y);
      of(point.term_residual) -= along[k] * of(directions[k]->term_image);
    }
    sums[0] += of(point.term_residual).squaredNorm();
  })[0];
  return std::sqrt(square + weight * term_square);
}

}  // namespace

SaddlePoint make_saddle_point(const Multigrid& multigrid) {
  const std::size_t size = multigrid.levels.front().lattice().num_slots() * vector_components;
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
  point.error = std::numeric_limits<double>::infinity();
  point.num_directions = 0;
}

SaddlePointReport solve(Multigrid& multigrid, SaddlePointMultigrid& coupled, const SaddlePointOptions& options,
                        SaddlePoint& point) {
  MultigridLevel& level = multigrid.levels.front();
  const BrickLattice& lattice = level.lattice();
  const RankOneTerms& terms = coupled.levels.front().terms;
  const double weight = coupled.weight;
  if (!point.pushed && point.error <= options.tolerance) return {0, point.error, point.error};
  double norm = advance(lattice, weight, point.pushed ? kept(point) : std::vector<const Direction*>{}, point);
  point.pushed = false;
  SaddlePointReport report;
  double error = 0, started = 0;
  bool stuck = false;
  while (norm > 0) {
    const Direction& last = point.directions[(point.num_directions + most_directions - 1) % most_directions];
    VectorXd y;
    const AlignedArray<float>& x = precondition(multigrid, coupled, stuck ? last.image : point.residual,
                                                stuck ? last.term_image : point.term_residual, y);
    Direction& d = point.directions[point.num_directions % most_directions];
    copy(lattice, x, d.x);
    const double size = std::sqrt(std::max(0.0, apply(level.op, level.matrix, d.x, d.image)));
    if (!stuck) error = size;
    if (started == 0) started = error;
    point.largest_error = std::max(point.largest_error, error);
    const auto is_small = [&] {
      report.error = point.largest_error > 0 ? error / point.largest_error : 0;
      report.started = point.largest_error > 0 ? started / point.largest_error : 0;
      return !(error > 0) || report.error <= options.tolerance || error <= options.reduction * started;
    };
    const bool was_small = is_small();  // then one iteration more, as its cycle is there
    if (!(error > 0) || report.iterations == options.max_iterations) break;
    d.y = y;
    d.term_image.resize(y.size());
    if (y.size() > 0) {
      multiply(terms, d.x, d.term_image);
      d.term_image -= d.y;
      add(terms, d.y, d.image);
    }
    orthogonalise(lattice, weight, kept(point), d);
    if (!(d.square > 0) || !std::isfinite(d.square)) break;
    ++point.num_directions;
    ++report.iterations;
    const double before = std::exchange(norm, advance(lattice, weight, {&d}, point));
    error *= norm / before;  // as far as can be told without another cycle
    stuck = norm > stuck_share * before;
    if (is_small() || was_small) break;
  }
  point.error = report.error;
  return report;
}

}  // namespace umax
