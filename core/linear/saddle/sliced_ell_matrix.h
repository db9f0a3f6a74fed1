// A symmetric sparse matrix in sliced ELL format (SELL-C; Kreutzer, Hager, Wellein, Fehske, Bishop 2014), between the
// rank-one terms of hexes that share a node: fast to multiply with.
//
// A slice is 16 rows. Where hexes have terms most of their neighbours have, so a slice has one term of each cell in a
// line of 16 along z, and a line as many slices as the richest of its cells has terms. Lanes without a term are zeros.
// The rows of a slice have their entries at the same places of 16 consecutive lanes: one index for 16 of them.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <vector>

#include "core/linear/bricks/multigrid_kernel.h"
#include "core/linear/saddle/rank_one_terms.h"

namespace umax {

/// Places of hexes near one: 9 (dx + 1) + 3 (dy + 1) + dz + 1.
inline constexpr int num_near = 27;
inline constexpr int own_place = num_near / 2;

/// Lines of 16 cells along z with terms, and those beyond the ends of one that has terms there.
struct TermLines {
  using Place = std::array<int, 3>;        // z in lines
  std::vector<Place> places;               // ascending; the line above follows
  std::vector<int> first_slices;           // and the end
  std::vector<std::array<int, 9>> beside;  // lines at the same z: 3 (dx + 1) + dy + 1; -1: none
  std::vector<int> hexes;                  // of each lane, -1: none with terms
  int most_layers = 1;                     // slices of a line

  int count() const { return int(places.size()); }
  int layers(int line) const { return first_slices[line + 1] - first_slices[line]; }
  bool continues(int line) const {
    return line + 1 < count() && places[line + 1] == Place{places[line][0], places[line][1], places[line][2] + 1};
  }
};
TermLines lines_of(const RankOneTerms& terms);

/// Scaled so that the diagonal is one, which is not stored.
struct SlicedEllMatrix {
  InstructionSet instruction_set = InstructionSet::portable;
  std::vector<std::int32_t> below, above, starts, places;  // as EllSlices
  std::vector<std::int16_t> entries;
  std::vector<int> lanes;      // of each term
  VectorXf scale;              // of its rows and columns, as handed in
  float largest = 1;           // no eigenvalue of the scaled matrix is larger
  VectorXf rest, x, moves[2];  // while solving: of the lanes, and with the lanes beside
};

/// The off-diagonal entries of G^T B G; responses: B's of each term, zero but for the hex's nodes; scale: 1 / sqrt of the
/// diagonal.
SlicedEllMatrix make_sliced_ell_matrix(const RankOneTerms& terms, const TermLines& lines,
                                       const std::vector<RankOneTerms::Vector24f>& responses, const VectorXf& scale,
                                       InstructionSet instruction_set);

/// As the kernels see it.
EllSlices slices_of(const SlicedEllMatrix& matrix);

/// The same matrix as compressed columns of its lower triangle, with the diagonal, for a factor.
Eigen::SparseMatrix<double> lower_triangle(const RankOneTerms& terms, const TermLines& lines,
                                           const std::vector<RankOneTerms::Vector24f>& responses,
                                           const VectorXf& scale);

/// x ~ A^-1 b by steps of Chebyshev's iteration, which reduce the error at eigenvalues of the scaled matrix from the
/// largest one down to that over `interval`.
struct ChebyshevOptions {
  int steps = 0;
  float interval = 1;
};
VectorXf solve(SlicedEllMatrix& matrix, const ChebyshevOptions& options, const VectorXf& b);

}  // namespace umax
