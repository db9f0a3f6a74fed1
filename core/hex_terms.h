// Terms g g^T that each live on the nodes of one hex: what active limits and touching contacts add to the matrix.
//
// They may be 1e4 times stiffer than what is around them, more than any multigrid for A bears; so they stay outside of
// A, as rows of a saddle-point system (core/saddle_point.h, core/term_multigrid.h).
#pragma once

#include <array>
#include <vector>

#include "core/hex_operator.h"
#include "core/parallel.h"

namespace umax {

struct HexTerms {
  using Vector24f = Eigen::Matrix<float, 24, 1>;
  struct Hex {
    std::array<int, 8> nodes{};  // slots
    Vector3i cell{0, 0, 0};      // on the lattice
    int first = 0, end = 0;      // of its vectors
  };
  std::vector<Hex> hexes;              // those with terms, by colour: hexes of a colour share no nodes
  std::array<int, 9> colour_starts{};  // into hexes
  std::vector<Vector24f> vectors;      // g [sqrt(N/m)], zero at nodes that are not free
  std::vector<int> sources;            // which of the terms handed in each vector is
  VectorXd offsets;
};

/// Cells of a colour share no corners.
inline int colour_of(const Vector3i& cell) {
  return 4 * (cell[0] & 1) + 2 * (cell[1] & 1) + (cell[2] & 1);
}

/// One term as it is handed in.
struct HexTerm {
  int hex = 0;  // of the lattice
  Vector24d vector = Vector24d::Zero();
  double offset = 0;  // [sqrt(J)] the term's force is -g (g . x + offset)
};

/// Sorts the terms, zeroes them at nodes that are not free. cells, node_slots: as in BrickLattice's functions.
HexTerms make_hex_terms(const std::vector<HexTerm>& terms, const Cells& cells, const Hexes& hexes, int first_node,
                        const std::vector<int>& node_slots, const AlignedArray<float>& diagonal);

/// Calls body(hex) for every hex with terms, at the same time only for hexes that share no nodes: it may write there.
template <class Body>
void for_each_apart(const HexTerms& terms, const Body& body) {
  constexpr Eigen::Index grain = 64;  // hexes per task
  for (int colour = 0; colour < 8; ++colour) {
    const int first = terms.colour_starts[colour], count = terms.colour_starts[colour + 1] - first;
    parallel_blocks(count, grain, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index h = first + begin; h < first + end; ++h) body(terms.hexes[h]);
    });
  }
}

/// products = G^T x.
template <class Vector>
void multiply(const HexTerms& terms, const AlignedArray<float>& x, Vector& products);

/// x += G factors, in a fixed order.
template <class Vector>
void add(const HexTerms& terms, const Vector& factors, AlignedArray<float>& x);

}  // namespace umax
