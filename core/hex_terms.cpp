#include "core/hex_terms.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index grain = 64;  // hexes per task

// How much more a single hex gives way than its nodes one by one would, g^T A^-1 g over g^T D^-1 g: of forces that
// strain it. Measured on the beam: half or twice as much takes a quarter more iterations.
constexpr double compliance = 1;

int colour_of(const Cells& cells, int hex) {
  return 4 * (cells(hex, 0) & 1) + 2 * (cells(hex, 1) & 1) + (cells(hex, 2) & 1);
}

HexTerms::Vector24f gather(const HexTerms::Hex& hex, const AlignedArray<float>& x) {
  HexTerms::Vector24f local;
  for (int n = 0; n < 8; ++n)
    for (int c = 0; c < 3; ++c)
      local[3 * n + c] = x[slot_offset(hex.nodes[n], vector_components) + std::size_t(c) * brick_lanes];
  return local;
}

// D^-1 g
HexTerms::Vector24f point_solution(const HexTerms::Hex& hex, const HexTerms::Vector24f& g,
                                   const AlignedArray<float>& inverse) {
  HexTerms::Vector24f solution;
  for (int n = 0; n < 8; ++n)
    solution.segment<3>(3 * n) = inverse_block(inverse, hex.nodes[n]).cast<float>() * g.segment<3>(3 * n);
  return solution;
}

MatrixXd block_inverse(const HexTerms& terms, const HexTerms::Hex& hex, const AlignedArray<float>& inverse) {
  const int count = hex.end - hex.first;
  MatrixXd block = MatrixXd::Identity(count, count);
  for (int i = 0; i < count; ++i) {
    const HexTerms::Vector24f solution = point_solution(hex, terms.vectors[hex.first + i], inverse);
    for (int j = 0; j < count; ++j) block(i, j) += compliance * double(solution.dot(terms.vectors[hex.first + j]));
  }
  return block.llt().solve(MatrixXd::Identity(count, count));
}

}  // namespace

HexTerms make_hex_terms(const std::vector<HexTerm>& terms, const Cells& cells, const Hexes& hexes, int first_node,
                        const std::vector<int>& node_slots, const AlignedArray<float>& diagonal,
                        const AlignedArray<float>& inverse) {
  std::array<std::vector<int>, 8> by_colour;
  for (std::size_t t = 0; t < terms.size(); ++t) by_colour[colour_of(cells, terms[t].hex)].push_back(int(t));
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
  sorted.inverses.resize(sorted.hexes.size());
  parallel_blocks(Eigen::Index(sorted.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) sorted.inverses[h] = block_inverse(sorted, sorted.hexes[h], inverse);
  });
  return sorted;
}

VectorXd precondition(const HexTerms& terms, const VectorXd& values) {
  VectorXd out(values.size());
  for (std::size_t h = 0; h < terms.hexes.size(); ++h) {
    const HexTerms::Hex& hex = terms.hexes[h];
    out.segment(hex.first, hex.end - hex.first).noalias() =
        terms.inverses[h] * values.segment(hex.first, hex.end - hex.first);
  }
  return out;
}

void multiply(const HexTerms& terms, const AlignedArray<float>& x, VectorXd& products) {
  parallel_blocks(Eigen::Index(terms.hexes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index h = begin; h < end; ++h) {
      const HexTerms::Hex& hex = terms.hexes[h];
      const Eigen::Matrix<double, 24, 1> local = gather(hex, x).cast<double>();
      for (int t = hex.first; t < hex.end; ++t) products[t] = terms.vectors[t].cast<double>().dot(local);
    }
  });
}

void add(const HexTerms& terms, const VectorXd& factors, AlignedArray<float>& x) {
  for (int colour = 0; colour < 8; ++colour) {
    const int first = terms.colour_starts[colour], count = terms.colour_starts[colour + 1] - first;
    parallel_blocks(count, grain, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index h = first + begin; h < first + end; ++h) {
        const HexTerms::Hex& hex = terms.hexes[h];
        HexTerms::Vector24f sum = float(factors[hex.first]) * terms.vectors[hex.first];
        for (int t = hex.first + 1; t < hex.end; ++t) sum += float(factors[t]) * terms.vectors[t];
        for (int n = 0; n < 8; ++n)
          for (int c = 0; c < 3; ++c)
            x[slot_offset(hex.nodes[n], vector_components) + std::size_t(c) * brick_lanes] += sum[3 * n + c];
      }
    });
  }
}

}  // namespace umax
