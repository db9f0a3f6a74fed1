#include "core/linear/saddle/limit_schur_complement.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

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
            LimitSchurComplement& S, Eigen::Index most_factored) {
  const TermLines lines = lines_of(terms);
  const std::vector<RankOneTerms::Vector24f> responses = responses_of(grid, terms, w);
  S.scale.resize(own.size());
  for (Eigen::Index t = 0; t < own.size(); ++t)
    S.scale[t] = 1 / std::sqrt(own[t] + responses[std::size_t(t)].dot(terms.vectors[std::size_t(t)]));
  S.is_factored = own.size() <= most_factored &&
                  factorize(lower_triangle(terms, lines, responses, S.scale), elimination_order(terms), S.factor);
  if (!S.is_factored) S.matrix = make_sliced_ell_matrix(terms, lines, responses, S.scale, grid.op.instruction_set);
}

VectorXf solve(LimitSchurComplement& S, const VectorXf& b) {
  if (!S.is_factored) return solve(S.matrix, unfactored, b);
  return S.scale.cwiseProduct(solve(S.factor, S.scale.cwiseProduct(b).cast<double>()).cast<float>());
}

}  // namespace umax
