#include "core/linear/saddle/rank_one_terms.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace umax {
namespace {

constexpr Eigen::Index grain = 64;  // hexes per task

}  // namespace

RankOneTerms make_rank_one_terms(const std::vector<RankOneTerm>& terms, const Cells& cells, const Hexes& hexes,
                                 int first_node, const std::vector<int>& node_slots,
                                 const AlignedArray<float>& diagonal) {
  std::vector<int> order(terms.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return terms[a].hex < terms[b].hex; });
  RankOneTerms sorted;
  sorted.vectors.reserve(terms.size());
  sorted.offsets.resize(Eigen::Index(terms.size()));
  int last = -1;
  for (const int t : order) {
    const RankOneTerm& term = terms[t];
    if (term.hex != last) {
      RankOneTerms::Hex hex;
      for (int n = 0; n < 8; ++n) hex.nodes[n] = node_slots[hexes(term.hex, n) - first_node];
      hex.cell = cells.row(term.hex);
      hex.first = int(sorted.vectors.size());
      sorted.hexes.push_back(hex);
      last = term.hex;
    }
    RankOneTerms::Vector24f g = term.vector.cast<float>();
    for (int n = 0; n < 8; ++n)
      if (!(diagonal[sorted.hexes.back().nodes[n]] > 0)) g.segment<3>(3 * n).setZero();
    sorted.offsets[Eigen::Index(sorted.vectors.size())] = term.offset;
    sorted.vectors.push_back(g);
    sorted.groups.push_back(char(term.group));
    sorted.hexes.back().end = int(sorted.vectors.size());
  }
  sorted.sources = std::move(order);
  sort_by_nodes(diagonal.size(), sorted);
  return sorted;
}

void sort_by_nodes(std::size_t num_slots, RankOneTerms& terms) {
  std::vector<int> places(num_slots, 0);  // of each node: how many vectors it has, then where its next one goes
  for (const RankOneTerms::Hex& hex : terms.hexes)
    for (const int slot : hex.nodes) places[slot] += hex.end - hex.first;
  terms.node_slots.clear();
  terms.node_starts = {0};
  for (std::size_t slot = 0; slot < num_slots; ++slot) {
    if (places[slot] == 0) continue;
    const int first = terms.node_starts.back();
    terms.node_slots.push_back(int(slot));
    terms.node_starts.push_back(first + std::exchange(places[slot], first));
  }
  terms.at_nodes.resize(8 * terms.vectors.size());
  for (const RankOneTerms::Hex& hex : terms.hexes)
    for (int t = hex.first; t < hex.end; ++t)
      for (int n = 0; n < 8; ++n) terms.at_nodes[places[hex.nodes[n]]++] = {t, terms.vectors[t].segment<3>(3 * n)};
}

template <class Vector>
void multiply(const RankOneTerms& terms, const AlignedArray<float>& x, Vector& products) {
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const RankOneTerms::Hex& hex = terms.hexes[h];
      using Scalar = typename Vector::Scalar;  // that sums are in, too
      const auto local = gather_nodes(hex.nodes, x).cast<Scalar>().eval();
      for (int t = hex.first; t < hex.end; ++t) products[t] = terms.vectors[t].cast<Scalar>().dot(local);
    }
  });
}

template <class Vector>
void add(const RankOneTerms& terms, const Vector& factors, AlignedArray<float>& x) {
  for_each_node(terms, factors, [&](int slot, const Vector3f& sum) { add_at_node(slot, sum, x); });
}

template void multiply(const RankOneTerms&, const AlignedArray<float>&, VectorXd&);
template void multiply(const RankOneTerms&, const AlignedArray<float>&, VectorXf&);
template void add(const RankOneTerms&, const VectorXd&, AlignedArray<float>&);
template void add(const RankOneTerms&, const VectorXf&, AlignedArray<float>&);

}  // namespace umax
