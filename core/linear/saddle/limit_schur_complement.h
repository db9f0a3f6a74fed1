// The Schur complement of the saddle-point system (Benzi, Golub, Liesen 2005, Section 5) with A's diagonal blocks in
// A's place: how the multipliers of energy limits depend on each other in a smoothing step of its multigrid.
//
//   S = C + w G^T D^-1 G,   C: diagonal; D: 3 x 3 diagonal blocks of A
// It has entries for hexes that share a node. Where multipliers hold each other in balance along a line of hexes it is
// nearly singular.
#pragma once

#include "core/linear/direct/supernodal_factor.h"
#include "core/linear/multigrid/multigrid.h"
#include "core/linear/saddle/sliced_ell_matrix.h"

namespace umax {

struct LimitSchurComplement {
  VectorXf scale;  // 1 / sqrt of its diagonal
  bool is_factored = false;
  SupernodalFactor factor;  // of the scaled matrix
  SlicedEllMatrix matrix;   // the same where it is not factored
};

inline constexpr Eigen::Index most_factored_terms = 10000;

/// For terms on the level's lattice, whose matrix and inverse are known; own: C. Of more terms than are to be factored, or
/// where S is singular to rounding, it is multiplied with.
void set_up(const MultigridLevel& level, const RankOneTerms& terms, const VectorXf& own, float w,
            LimitSchurComplement& S, Eigen::Index most_factored = most_factored_terms);

/// S^-1 b, where terms are many nearly.
VectorXf solve(LimitSchurComplement& S, const VectorXf& b);

}  // namespace umax
