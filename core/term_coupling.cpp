#include "core/term_coupling.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <tuple>
#include <vector>

namespace umax {
namespace {

// Entries of the factor over n^(4/3) of n terms: 7.5 with 2051, 9 with 12,773, 10 with 84,109. A sweep over the lattice
// costs as much as 50 entries a slot would, and a fifth of the iterations is left.
constexpr double factor_entries = 10;
constexpr double most_entries = 50;  // per slot of the lattice

struct TermAtNode {
  int node = 0, term = 0, corner = 0;
  auto key() const { return std::tie(node, term); }
};

// by node, then by term
std::vector<TermAtNode> terms_at_nodes(const HexTerms& terms) {
  std::vector<TermAtNode> list;
  list.reserve(8 * terms.vectors.size());
  for (const HexTerms::Hex& hex : terms.hexes)
    for (int n = 0; n < 8; ++n)
      for (int t = hex.first; t < hex.end; ++t) list.push_back({hex.nodes[n], t, n});
  std::sort(list.begin(), list.end(), [](const TermAtNode& a, const TermAtNode& b) { return a.key() < b.key(); });
  return list;
}

// the lower triangle of P
Eigen::SparseMatrix<double> coupling_matrix(const HexTerms& terms, const AlignedArray<float>& inverse) {
  const auto part = [&](const TermAtNode& at) -> Vector3d {
    return terms.vectors[at.term].segment<3>(3 * at.corner).cast<double>();
  };
  const auto count = Eigen::Index(terms.vectors.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int t = 0; t < int(count); ++t) entries.emplace_back(t, t, 1.0);
  const std::vector<TermAtNode> list = terms_at_nodes(terms);
  for (auto first = list.begin(); first != list.end();) {
    const auto end = std::find_if(first, list.end(), [&](const TermAtNode& at) { return at.node != first->node; });
    const Matrix3d D = inverse_block(inverse, first->node);
    for (auto column = first; column != end; ++column) {
      const Vector3d moved = D * part(*column);
      for (auto row = column; row != end; ++row) entries.emplace_back(row->term, column->term, moved.dot(part(*row)));
    }
    first = end;
  }
  Eigen::SparseMatrix<double> matrix(count, count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
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

}  // namespace

TermCoupling make_term_coupling(const HexTerms& terms, const AlignedArray<float>& inverse) {
  TermCoupling coupling;
  const double count = double(terms.vectors.size()), slots = double(inverse.size() / inverse_components);
  if (count > 0 && factor_entries * std::pow(count, 4.0 / 3) <= most_entries * slots)
    coupling.exists = factorize(coupling_matrix(terms, inverse), elimination_order(terms), coupling.factor);
  return coupling;
}

}  // namespace umax
