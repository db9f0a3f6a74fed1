// Rank-one terms g g^T that each live on the nodes of one hex: what active limits and touching contacts add to the
// matrix A of a step.
//
// They may be 1e4 times stiffer than what is around them, more than any multigrid for A bears; so they stay outside of
// A, as rows of a saddle-point system (core/linear/saddle/saddle_point.h).
#pragma once

#include <array>
#include <vector>

#include "core/base/parallel.h"
#include "core/linear/bricks/hex_operator.h"

namespace umax {

struct RankOneTerms {
  using Vector24f = Eigen::Matrix<float, 24, 1>;
  struct Hex {
    std::array<int, 8> nodes{};  // slots
    Vector3i cell{0, 0, 0};      // on the lattice
    int first = 0, end = 0;      // of its vectors
  };
  std::vector<Hex> hexes;          // those with terms, in the order of the lattice
  std::vector<Vector24f> vectors;  // g [sqrt(N/m)], zero at nodes that are not free
  std::vector<int> sources;        // which of the terms handed in each vector is
  std::vector<char> groups;        // RankOneTerm::group of each vector
  VectorXd offsets;
  // the same vectors, by nodes: what pushes nodes reads them one after the other
  struct AtNode {
    int vector = 0;
    Vector3f g = Vector3f::Zero();
  };
  std::vector<int> node_slots;   // of the nodes of these hexes, ascending
  std::vector<int> node_starts;  // into at_nodes, and the end
  std::vector<AtNode> at_nodes;
};

inline constexpr int most_term_groups = 3;

/// One term as it is handed in.
struct RankOneTerm {
  int hex = 0;  // of the lattice
  Vector24d vector = Vector24d::Zero();
  double offset = 0;  // [sqrt(J)] the term's force is -g (g . x + offset)
  int group = 0;      // 1 .. most_term_groups: those of a group in a cell become one on coarser levels; 0: of none
};

/// Sorts the terms, zeroes them at nodes that are not free. cells, node_slots: as in BrickLattice's functions.
RankOneTerms make_rank_one_terms(const std::vector<RankOneTerm>& terms, const Cells& cells, const Hexes& hexes,
                                 int first_node, const std::vector<int>& node_slots,
                                 const AlignedArray<float>& diagonal);

/// Sorts the vectors by nodes. num_slots: of the lattice.
void sort_by_nodes(std::size_t num_slots, RankOneTerms& terms);

/// Calls body(slot, G factors there) for every node of hexes with terms.
template <class Vector, class Body>
void for_each_node(const RankOneTerms& terms, const Vector& factors, const Body& body) {
  constexpr Eigen::Index grain = 256;  // nodes per task
  parallel_blocks(Eigen::Index(terms.node_slots.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      Vector3f sum = Vector3f::Zero();
      for (int at = terms.node_starts[i]; at < terms.node_starts[i + 1]; ++at)
        sum += float(factors[terms.at_nodes[at].vector]) * terms.at_nodes[at].g;
      body(terms.node_slots[i], sum);
    }
  });
}

/// products = G^T x.
template <class Vector>
void multiply(const RankOneTerms& terms, const AlignedArray<float>& x, Vector& products);

/// x += G factors, in a fixed order.
template <class Vector>
void add(const RankOneTerms& terms, const Vector& factors, AlignedArray<float>& x);

}  // namespace umax
