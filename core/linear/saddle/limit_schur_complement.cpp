#include "core/linear/saddle/limit_schur_complement.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index most_factored = 10000;                         // terms
constexpr ChebyshevOptions unfactored{.steps = 12, .interval = 150};  // more take as many iterations
constexpr Eigen::Index grain = 64;                                    // hexes per task

// Nested dissection in space, [first, end) of hexes: a layer of them parts the others and is eliminated after these.
void dissect(const std::vector<RankOneTerms::Hex>& of_terms, std::vector<int>::iterator first,
             std::vector<int>::iterator end) {
  constexpr std::ptrdiff_t small = 16;
  if (end - first <= small) return;
  Vector3i least = of_terms[*first].cell, most = least;
  for (auto at = first; at != end; ++at) {
    least = least.cwiseMin(of_terms[*at].cell);
    most = most.cwiseMax(of_terms[*at].cell);
  }
  int axis = 0;
  (most - least).maxCoeff(&axis);
  if (least[axis] == most[axis]) return;
  const auto place = [&](int hex) { return of_terms[hex].cell[axis]; };
  std::vector<int> places;
  std::transform(first, end, std::back_inserter(places), place);
  const auto middle = places.begin() + std::ssize(places) / 2;
  std::nth_element(places.begin(), middle, places.end());
  const int layer = *middle;
  const auto below = std::stable_partition(first, end, [&](int hex) { return place(hex) < layer; });
  const auto above = std::stable_partition(below, end, [&](int hex) { return place(hex) > layer; });
  dissect(of_terms, first, below);
  dissect(of_terms, below, above);
}

std::vector<int> elimination_order(const RankOneTerms& terms) {
  std::vector<int> hexes(terms.hexes.size()), order;
  std::iota(hexes.begin(), hexes.end(), 0);
  dissect(terms.hexes, hexes.begin(), hexes.end());
  for (const int hex : hexes)
    for (int t = terms.hexes[hex].first; t < terms.hexes[hex].end; ++t) order.push_back(t);
  return order;
}

// of the scaled matrix
bool factorize(const RankOneTerms& terms, const TermLines& lines, const SlicedEllMatrix& matrix,
               SupernodalFactor& factor) {
  std::vector<Eigen::Triplet<double>> entries = lower_entries(terms, lines, matrix);
  const Eigen::Index count = matrix.scale.size();
  for (Eigen::Index t = 0; t < count; ++t) entries.emplace_back(t, t, 1.0);
  Eigen::SparseMatrix<double> lower(count, count);
  lower.setFromTriplets(entries.begin(), entries.end());
  return factorize(lower, elimination_order(terms), factor);
}

// w D^-1 g of each term
std::vector<RankOneTerms::Vector24f> responses_of(const MultigridLevel& grid, const RankOneTerms& terms, float w) {
  std::vector<RankOneTerms::Vector24f> responses(terms.vectors.size());
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const RankOneTerms::Hex& hex = terms.hexes[h];
      std::array<Matrix3f, 8> inverses;
      for (int n = 0; n < 8; ++n) inverses[n] = w * inverse_block(grid.inverse, hex.nodes[n]);
      for (int t = hex.first; t < hex.end; ++t)
        for (int n = 0; n < 8; ++n) responses[t].segment<3>(3 * n) = inverses[n] * terms.vectors[t].segment<3>(3 * n);
    }
  });
  return responses;
}

}  // namespace

void set_up(const MultigridLevel& grid, const RankOneTerms& terms, const VectorXf& own, float w,
            LimitSchurComplement& S) {
  const TermLines lines = lines_of(terms);
  S.matrix = make_sliced_ell_matrix(terms, lines, responses_of(grid, terms, w), own, grid.op.instruction_set);
  S.is_factored = own.size() <= most_factored && factorize(terms, lines, S.matrix, S.factor);
}

VectorXf solve(LimitSchurComplement& S, const VectorXf& b) {
  if (!S.is_factored) return solve(S.matrix, unfactored, b);
  const VectorXf& scale = S.matrix.scale;
  return scale.cwiseProduct(solve(S.factor, scale.cwiseProduct(b).cast<double>()).cast<float>());
}

}  // namespace umax
