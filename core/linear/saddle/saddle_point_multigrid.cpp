#include "core/linear/saddle/saddle_point_multigrid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/linear/direct/sparse_cholesky.h"
#include "core/linear/multigrid/multigrid_cycle.h"

namespace umax {
namespace {

constexpr double damping = 1.9;         // w lambda, lambda the largest eigenvalue of D^-1 A: 2 and more diverge
constexpr int smoothings = 2;           // before the coarser level, and after it: one does not converge
constexpr int coarsest_smoothings = 8;  // where the last level is not factored
constexpr Eigen::Index most_dense_terms = 1000;  // on the last level, for it to be factored
constexpr Eigen::Index columns_per_block = 64;

using Vector24f = RankOneTerms::Vector24f;

// P^T g is G W, G: g as 3 x 8; W(n, m) for a cell at `place`, one of corner(), in its coarse cell
using Weights = Eigen::Matrix<float, 8, 8>;
std::array<Weights, 8> restriction_weights(const Vector3i& factor) {
  std::array<Weights, 8> weights;
  for (int place = 0; place < 8; ++place)
    for (int n = 0; n < 8; ++n)
      for (int m = 0; m < 8; ++m) weights[place](n, m) = float(coarse_weight(corner(place) + corner(n), factor, m));
  return weights;
}

// fills fine.parents
SaddlePointLevel coarser_terms(const MultigridLevel& fine_grid, const MultigridLevel& coarse_grid,
                               SaddlePointLevel& fine) {
  const std::vector<RankOneTerms::Hex>& hexes = fine.terms.hexes;
  const auto parent = [&](int h) -> Vector3i { return hexes[h].cell.cwiseQuotient(fine_grid.factor); };
  std::vector<std::pair<std::array<int, 3>, int>> order;  // places of parents, and hexes
  for (int h = 0; h < int(hexes.size()); ++h) {
    const Vector3i cell = parent(h);
    order.push_back({{cell[0], cell[1], cell[2]}, h});
  }
  std::sort(order.begin(), order.end());

  const std::array<Weights, 8> weights = restriction_weights(fine_grid.factor);
  SaddlePointLevel coarse;
  RankOneTerms& terms = coarse.terms;
  fine.parents.resize(fine.terms.vectors.size());
  std::vector<float> own;
  for (auto first = order.begin(); first != order.end();) {
    const auto end = std::find_if(first, order.end(), [&](const auto& entry) { return entry.first != first->first; });
    RankOneTerms::Hex hex;
    hex.cell = parent(first->second);
    for (int n = 0; n < 8; ++n) hex.nodes[n] = slot_of(coarse_grid.lattice(), hex.cell + corner(n));
    int richest = 0;  // of terms in no group
    std::array<int, most_term_groups + 1> places{};
    for (auto at = first; at != end; ++at) {
      int single = 0;
      for (int t = hexes[at->second].first; t < hexes[at->second].end; ++t) {
        const int group = fine.terms.groups[t];
        group == 0 ? ++single : places[group] = 1;
      }
      richest = std::max(richest, single);
    }
    hex.first = int(terms.vectors.size());
    hex.end = hex.first + richest;
    terms.groups.resize(hex.end, 0);
    for (int group = 1; group <= most_term_groups; ++group) {
      if (places[group] == 0) continue;
      places[group] = hex.end++;
      terms.groups.push_back(char(group));
    }
    terms.vectors.resize(hex.end, Vector24f::Zero());
    own.resize(hex.end, 0);
    for (auto at = first; at != end; ++at) {
      const RankOneTerms::Hex& covered = hexes[at->second];
      const Vector3i place = covered.cell - hex.cell.cwiseProduct(fine_grid.factor);
      const Weights& W = weights[4 * place[0] + 2 * place[1] + place[2]];
      int single = 0;
      for (int t = covered.first; t < covered.end; ++t) {
        const int group = fine.terms.groups[t], to = group == 0 ? hex.first + single++ : places[group];
        fine.parents[t] = to;
        using Nodes = Eigen::Matrix<float, 3, 8>;
        Eigen::Map<Nodes>(terms.vectors[to].data()) +=
            Eigen::Map<const Nodes>(fine.terms.vectors[t].data()).lazyProduct(W);
        own[to] += fine.own[t];
      }
    }
    for (int n = 0; n < 8; ++n)
      if (!(coarse_grid.matrix.diagonal[hex.nodes[n]] > 0))
        for (int t = hex.first; t < hex.end; ++t) terms.vectors[t].segment<3>(3 * n).setZero();
    terms.hexes.push_back(hex);
    first = end;
  }
  sort_by_nodes(coarse_grid.lattice().num_slots(), terms);
  coarse.own = Eigen::Map<const VectorXf>(own.data(), Eigen::Index(own.size()));
  return coarse;
}

void set_up_last(const Multigrid& multigrid, SaddlePointMultigrid& coupled) {
  const SaddlePointLevel& level = coupled.levels.back();
  const auto count = Eigen::Index(level.terms.vectors.size());
  const std::vector<int>& slots = multigrid.dense_slots;
  MatrixXd G = MatrixXd::Zero(3 * Eigen::Index(slots.size()), count);
  for (const RankOneTerms::Hex& hex : level.terms.hexes)
    for (int n = 0; n < 8; ++n) {
      const auto row = std::lower_bound(slots.begin(), slots.end(), hex.nodes[n]) - slots.begin();
      for (int t = hex.first; t < hex.end; ++t)
        G.block<3, 1>(3 * row, t) = level.terms.vectors[t].segment<3>(3 * n).cast<double>();
    }
  parallel_blocks(count, columns_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    solve_lower(multigrid.dense, G.middleCols(begin, end - begin));
  });
  MatrixXd S = level.own.cast<double>().asDiagonal();
  S.selfadjointView<Eigen::Lower>().rankUpdate(G.transpose());
  coupled.half_responses = std::move(G);
  coupled.dense.compute(S);
}

// the mean of 1 / S_ii over that of D^-1 at free nodes
double weight_of(const MultigridLevel& grid, const SaddlePointLevel& level) {
  double sum = 0;
  Eigen::Index count = 0;
  for (const RankOneTerms::Hex& hex : level.terms.hexes)
    for (const int node : hex.nodes) {
      if (!(grid.matrix.diagonal[node] > 0)) continue;
      sum += double(inverse_block(grid.inverse, node).trace()) / 3;
      ++count;
    }
  if (count == 0) return 1;
  const VectorXd scale = level.complement.scale.cast<double>();
  return scale.squaredNorm() / double(scale.size()) / (sum / double(count));
}

// (x, v) -= (w D^-1 G, G) dy
void push_back(const MultigridLevel& grid, const SaddlePointLevel& level, float w, const VectorXf& dy,
               AlignedArray<float>& x, AlignedArray<float>& v) {
  for_each_node(level.terms, dy, [&](int slot, const Vector3f& sum) {
    add_at_node(slot, -w * (inverse_block(grid.inverse, slot) * sum), x);
    add_at_node(slot, -sum, v);
  });
}

VectorXf products(const SaddlePointLevel& level, const AlignedArray<float>& x) {
  VectorXf of_x(level.own.size());
  multiply(level.terms, x, of_x);
  return of_x;
}

// the multipliers that bring x back to the terms; v: b - G y
void project(const MultigridLevel& grid, SaddlePointLevel& level, float w, const VectorXf& q, AlignedArray<float>& x,
             AlignedArray<float>& v, VectorXf& y) {
  const VectorXf dy = solve(level.complement, products(level, x) - q - level.own.cwiseProduct(y));
  y += dy;
  push_back(grid, level, w, dy, x, v);
}

// returns which iterate is current
int smooth_coupled(MultigridLevel& grid, SaddlePointLevel& level, float w, const VectorXf& q, int current,
                   AlignedArray<float>& v, VectorXf& y) {
  chebyshev(grid.op, grid.matrix, grid.inverse, {1, 0, w}, v, grid.x[current], grid.x[1 - current]);
  project(grid, level, w, q, grid.x[1 - current], v, y);
  return 1 - current;
}

float damping_of(const MultigridLevel& grid) {
  return float(damping / grid.largest_eigenvalue);
}

AlignedArray<float>& solve_last(Multigrid& multigrid, const SaddlePointMultigrid& coupled, const AlignedArray<float>& b,
                                const VectorXf& q, VectorXf& y) {
  VectorXd x = dense_values(multigrid, b);
  solve_lower(multigrid.dense, x);
  if (q.size() > 0) {
    const MatrixXd& H = coupled.half_responses;
    const VectorXd solved = coupled.dense.solve(H.transpose() * x - q.cast<double>());
    y = solved.cast<float>();
    x -= H * solved;
  }
  solve_upper(multigrid.dense, x);
  return set_dense_values(x, multigrid);
}

// v: the right-hand side, b; becomes b - G y. Returns x.
AlignedArray<float>& cycle(Multigrid& multigrid, SaddlePointMultigrid& coupled, std::size_t depth,
                           AlignedArray<float>& v, const VectorXf& q, VectorXf& y) {
  MultigridLevel& grid = multigrid.levels[depth];
  SaddlePointLevel& level = coupled.levels[depth];
  y = VectorXf::Zero(q.size());
  const bool last = depth + 1 == multigrid.levels.size();
  if (last && coupled.has_dense) return solve_last(multigrid, coupled, v, q, y);
  const float w = damping_of(grid);
  const int before = last ? coarsest_smoothings : smoothings;
  jacobi_from_zero(grid, v, w);
  project(grid, level, w, q, grid.x[0], v, y);
  int current = 0;
  for (int i = 1; i < before; ++i) current = smooth_coupled(grid, level, w, q, current, v, y);
  if (last) return grid.x[current];

  const VectorXf rest = q - products(level, grid.x[current]) + level.own.cwiseProduct(y);
  VectorXf coarse_q = VectorXf::Zero(coupled.levels[depth + 1].own.size()), coarse_y;
  for (Eigen::Index t = 0; t < rest.size(); ++t) coarse_q[level.parents[t]] += rest[t];
  restrict_residual(multigrid, depth, v, current);
  const AlignedArray<float>& correction =
      cycle(multigrid, coupled, depth + 1, multigrid.levels[depth + 1].b, coarse_q, coarse_y);
  prolong(multigrid, depth, correction, current);
  VectorXf dy(q.size());
  for (Eigen::Index t = 0; t < dy.size(); ++t) dy[t] = -coarse_y[level.parents[t]];
  y -= dy;
  add(level.terms, dy, v);
  for (int i = 0; i < smoothings; ++i) current = smooth_coupled(grid, level, w, q, current, v, y);
  return grid.x[current];
}

}  // namespace

void set_up(Multigrid& multigrid, RankOneTerms terms, SaddlePointMultigrid& coupled) {
  const MultigridLevel& finest = multigrid.levels.front();
  for (RankOneTerms::Hex& hex : terms.hexes) hex.cell -= finest.lattice().first_cell;
  coupled.levels.clear();
  coupled.levels.emplace_back().terms = std::move(terms);
  const auto count = Eigen::Index(coupled.levels.front().terms.vectors.size());
  coupled.levels.front().own = VectorXf::Ones(count);
  coupled.has_dense = false;
  if (count == 0) {
    factorize_last(multigrid);
    return set_up_stiff_cells(multigrid);
  }
  for (std::size_t depth = 1; depth < multigrid.levels.size(); ++depth) {
    SaddlePointLevel coarse =
        coarser_terms(multigrid.levels[depth - 1], multigrid.levels[depth], coupled.levels.back());
    coupled.levels.push_back(std::move(coarse));
  }
  coupled.has_dense =
      multigrid.has_dense && Eigen::Index(coupled.levels.back().terms.vectors.size()) <= most_dense_terms;
  const auto set_up_dense = [&] {
    factorize_last(multigrid);
    if (coupled.has_dense) set_up_last(multigrid, coupled);
  };
  // of the levels that are smoothed, and of the first one, whose complement tells the weight
  const std::size_t complements = std::max<std::size_t>(1, multigrid.levels.size() - (coupled.has_dense ? 1 : 0));
  const auto set_up_complement = [&](Eigen::Index depth) {
    SaddlePointLevel& level = coupled.levels[depth];
    const MultigridLevel& grid = multigrid.levels[depth];
    set_up(grid, level.terms, level.own, damping_of(grid), level.complement);
  };
  // the longest parts first: the finest complement, then the last level
  for_each_solve(Eigen::Index(complements) + 1, [&](Eigen::Index part) {
    part == 1 ? set_up_dense() : set_up_complement(std::max<Eigen::Index>(0, part - 1));
  });
  coupled.weight = weight_of(finest, coupled.levels.front());
  if (coupled.rest.size() == 0) coupled.rest = AlignedArray<float>(finest.x[0].size());
}

const AlignedArray<float>& precondition(Multigrid& multigrid, SaddlePointMultigrid& coupled,
                                        const AlignedArray<float>& r, const VectorXd& q, VectorXd& y) {
  if (q.size() == 0) {
    double product = 0;
    y.resize(0);
    return precondition(multigrid, r, product);
  }
  copy(multigrid.levels.front().lattice(), r, coupled.rest);
  VectorXf of_terms;
  const AlignedArray<float>& x = cycle(multigrid, coupled, 0, coupled.rest, q.cast<float>(), of_terms);
  y = of_terms.cast<double>();
  return x;
}

}  // namespace umax
