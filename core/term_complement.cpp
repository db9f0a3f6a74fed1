#include "core/term_complement.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index most_factored = 10000;  // terms
constexpr int solver_steps = 8;                // half as many need twice the iterations where limits are many
constexpr float interval = 60;                 // of S's eigenvalues that they reduce: the largest over the smallest
constexpr Eigen::Index grain = 64;             // hexes per task
constexpr std::size_t slice_rows = 16;
constexpr Eigen::Index slice_grain = 64;  // slices per task

// corners that a cell shares with the one at `offset` from it: its own, the other's
std::vector<std::pair<int, int>> shared_corners(const Vector3i& offset) {
  std::vector<std::pair<int, int>> pairs;
  for (int n = 0; n < 8; ++n)
    for (int m = 0; m < 8; ++m)
      if (corner(n) == offset + corner(m)) pairs.emplace_back(n, m);
  return pairs;
}

// Nested dissection in space, [first, end) of hexes: a layer of them parts the others and is eliminated after these.
void dissect(const std::vector<HexTerms::Hex>& of_terms, std::vector<int>::iterator first,
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

std::vector<int> elimination_order(const HexTerms& terms) {
  std::vector<int> hexes(terms.hexes.size()), order;
  std::iota(hexes.begin(), hexes.end(), 0);
  dissect(terms.hexes, hexes.begin(), hexes.end());
  for (const int hex : hexes)
    for (int t = terms.hexes[hex].first; t < terms.hexes[hex].end; ++t) order.push_back(t);
  return order;
}

// of S, scaled
bool factorize(const HexTerms& terms, TermComplement& S) {
  const auto count = Eigen::Index(terms.vectors.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index t = 0; t < count; ++t) {
    entries.emplace_back(t, t, 1.0);
    const std::size_t slice = std::size_t(t) / slice_rows, row = std::size_t(t) % slice_rows;
    for (std::size_t i = S.slice_starts[slice] + row; i < S.slice_starts[slice + 1]; i += slice_rows)
      if (S.columns[i] < t && S.values[i] != 0) entries.emplace_back(t, S.columns[i], double(S.values[i]));
  }
  Eigen::SparseMatrix<double> lower(count, count);
  lower.setFromTriplets(entries.begin(), entries.end());
  return factorize(lower, elimination_order(terms), S.factor);
}

}  // namespace

void set_up(const MultigridLevel& grid, const HexTerms& terms, const VectorXf& own, float w, TermComplement& S) {
  const auto count = Eigen::Index(terms.vectors.size());
  std::array<std::vector<std::pair<int, int>>, 27> shared;
  for (int d = 0; d < 27; ++d) shared[d] = shared_corners({d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1});
  std::vector<std::array<int, 8>> hexes_at(grid.lattice.num_slots());  // by which corner of theirs a node is
  for (std::array<int, 8>& hexes : hexes_at) hexes.fill(-1);
  for (std::size_t h = 0; h < terms.hexes.size(); ++h)
    for (int n = 0; n < 8; ++n) hexes_at[terms.hexes[h].nodes[n]][n] = int(h);
  // number of the hex at an offset, or -1
  const auto neighbour = [&](const HexTerms::Hex& hex, int d) {
    const auto [at, its] = shared[d].front();
    return hexes_at[hex.nodes[at]][its];
  };

  S.responses.resize(terms.vectors.size());
  S.scale.resize(count);
  std::vector<int> row_lengths(terms.vectors.size());
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const HexTerms::Hex& hex = terms.hexes[h];
      int entries = 0;
      for (int d = 0; d < 27; ++d)
        if (const int other = neighbour(hex, d); other >= 0)
          entries += terms.hexes[other].end - terms.hexes[other].first;
      std::array<Eigen::Matrix3f, 8> inverses;
      for (int n = 0; n < 8; ++n) inverses[n] = w * inverse_block(grid.inverse, hex.nodes[n]).cast<float>();
      for (int t = hex.first; t < hex.end; ++t) {
        row_lengths[t] = entries - 1;
        for (int n = 0; n < 8; ++n) S.responses[t].segment<3>(3 * n) = inverses[n] * terms.vectors[t].segment<3>(3 * n);
        S.scale[t] = 1 / std::sqrt(own[t] + S.responses[t].dot(terms.vectors[t]));
      }
    }
  });
  const std::size_t slices = (terms.vectors.size() + slice_rows - 1) / slice_rows;
  S.slice_starts.assign(slices + 1, 0);
  for (std::size_t slice = 0; slice < slices; ++slice) {
    const std::size_t first = slice * slice_rows, end = std::min(first + slice_rows, row_lengths.size());
    const int longest = *std::max_element(row_lengths.begin() + first, row_lengths.begin() + end);
    S.slice_starts[slice + 1] = S.slice_starts[slice] + std::size_t(longest) * slice_rows;
  }
  S.columns.assign(S.slice_starts.back(), 0);
  S.values.assign(S.slice_starts.back(), 0);
  VectorXf row_sums(count);
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const HexTerms::Hex& hex = terms.hexes[h];
      for (int t = hex.first; t < hex.end; ++t) {
        std::size_t at = S.slice_starts[t / slice_rows] + t % slice_rows;
        float sum = 1;
        for (int d = 0; d < 27; ++d) {
          const int other = neighbour(hex, d);
          if (other < 0) continue;
          for (int u = terms.hexes[other].first; u < terms.hexes[other].end; ++u) {
            if (u == t) continue;
            float product = 0;
            for (const auto& [n, m] : shared[d])
              product += S.responses[t].segment<3>(3 * n).dot(terms.vectors[u].segment<3>(3 * m));
            product *= S.scale[t] * S.scale[u];
            S.columns[at] = u;
            S.values[at] = product;
            at += slice_rows;
            sum += std::abs(product);
          }
        }
        row_sums[t] = sum;
      }
    }
  });
  S.largest = count > 0 ? row_sums.maxCoeff() : 1;
  S.is_factored = count > 0 && count <= most_factored && factorize(terms, S);
}

VectorXf solve(const TermComplement& S, const VectorXf& b) {
  if (S.is_factored) return S.scale.cwiseProduct(solve(S.factor, S.scale.cwiseProduct(b).cast<double>()).cast<float>());
  const float theta = S.largest * (1 + 1 / interval) / 2, delta = S.largest * (1 - 1 / interval) / 2;
  const Eigen::Index count = b.size();
  VectorXf rest = S.scale.cwiseProduct(b), move = rest / theta, x = move;
  float rho = delta / theta;
  for (int step = 1; step < solver_steps; ++step) {
    const float next = 1 / (2 * theta / delta - rho), gain = 2 * next / delta, momentum = next * rho;
    // rest -= S move
    parallel_blocks(Eigen::Index(S.slice_starts.size()) - 1, slice_grain, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index slice = begin; slice < end; ++slice) {
        float sums[slice_rows] = {};
        for (std::size_t i = S.slice_starts[slice]; i < S.slice_starts[slice + 1]; i += slice_rows)
          for (std::size_t row = 0; row < slice_rows; ++row) sums[row] += S.values[i + row] * move[S.columns[i + row]];
        const Eigen::Index first = slice * Eigen::Index(slice_rows);
        for (Eigen::Index t = first; t < std::min(count, first + Eigen::Index(slice_rows)); ++t)
          rest[t] -= move[t] + sums[t - first];
      }
    });
    move = momentum * move + gain * rest;
    x += move;
    rho = next;
  }
  return S.scale.cwiseProduct(x);
}

}  // namespace umax
