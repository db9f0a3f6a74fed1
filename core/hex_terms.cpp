#include "core/hex_terms.h"

#include <algorithm>

namespace umax {
namespace {

constexpr Eigen::Index grain = 64;  // hexes per task

}  // namespace

HexTerms make_hex_terms(const std::vector<HexTerm>& terms, const Cells& cells, const Hexes& hexes, int first_node,
                        const std::vector<int>& node_slots, const AlignedArray<float>& diagonal) {
  std::array<std::vector<int>, 8> by_colour;
  for (std::size_t t = 0; t < terms.size(); ++t) by_colour[colour_of(cells.row(terms[t].hex))].push_back(int(t));
  HexTerms sorted;
  sorted.vectors.reserve(terms.size());
  sorted.sources.reserve(terms.size());
  sorted.offsets.resize(Eigen::Index(terms.size()));
  for (int colour = 0; colour < 8; ++colour) {
    sorted.colour_starts[colour] = int(sorted.hexes.size());
    std::vector<int>& of_colour = by_colour[colour];
    std::stable_sort(of_colour.begin(), of_colour.end(), [&](int a, int b) { return terms[a].hex < terms[b].hex; });
    int last = -1;
    for (const int t : of_colour) {
      const HexTerm& term = terms[t];
      if (term.hex != last) {
        HexTerms::Hex hex;
        for (int n = 0; n < 8; ++n) hex.nodes[n] = node_slots[hexes(term.hex, n) - first_node];
        hex.cell = cells.row(term.hex);
        hex.first = int(sorted.vectors.size());
        sorted.hexes.push_back(hex);
        last = term.hex;
      }
      HexTerms::Vector24f g = term.vector.cast<float>();
      for (int n = 0; n < 8; ++n)
        if (!(diagonal[sorted.hexes.back().nodes[n]] > 0)) g.segment<3>(3 * n).setZero();
      sorted.offsets[Eigen::Index(sorted.vectors.size())] = term.offset;
      sorted.vectors.push_back(g);
      sorted.sources.push_back(t);
      sorted.hexes.back().end = int(sorted.vectors.size());
    }
  }
  sorted.colour_starts[8] = int(sorted.hexes.size());
  return sorted;
}

template <class Vector>
void multiply(const HexTerms& terms, const AlignedArray<float>& x, Vector& products) {
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const HexTerms::Hex& hex = terms.hexes[h];
      using Scalar = typename Vector::Scalar;  // that sums are in, too
      const auto local = gather_nodes(hex.nodes, x).cast<Scalar>().eval();
      for (int t = hex.first; t < hex.end; ++t) products[t] = terms.vectors[t].cast<Scalar>().dot(local);
    }
  });
}

template <class Vector>
void add(const HexTerms& terms, const Vector& factors, AlignedArray<float>& x) {
  for_each_apart(terms, [&](const HexTerms::Hex& hex) {
    HexTerms::Vector24f sum = float(factors[hex.first]) * terms.vectors[hex.first];
    for (int t = hex.first + 1; t < hex.end; ++t) sum += float(factors[t]) * terms.vectors[t];
    add_at_nodes(hex.nodes, sum, x);
  });
}

template void multiply(const HexTerms&, const AlignedArray<float>&, VectorXd&);
template void multiply(const HexTerms&, const AlignedArray<float>&, VectorXf&);
template void add(const HexTerms&, const VectorXd&, AlignedArray<float>&);
template void add(const HexTerms&, const VectorXf&, AlignedArray<float>&);

}  // namespace umax
