// What couples the multipliers of terms in a smoothing step, the Schur complement
//
//   S = C + w G^T D^-1 G,   C: diagonal; D: 3 x 3 diagonal blocks of A
// It has entries for hexes that share a node. Where multipliers hold each other in balance along a line of hexes it is
// nearly singular.
#pragma once

#include "core/linear/direct/supernodal_factor.h"
#include "core/linear/multigrid/multigrid.h"
#include "core/linear/saddle/strip_matrix.h"

namespace umax {

struct TermComplement {
  StripMatrix matrix;
  bool is_factored = false;
  SupernodalFactor factor;  // of the scaled matrix
};

/// For terms on the level's lattice, whose matrix and inverse are known; own: C.
void set_up(const MultigridLevel& level, const HexTerms& terms, const VectorXf& own, float w, TermComplement& S);

/// S^-1 b, where terms are many nearly.
VectorXf solve(TermComplement& S, const VectorXf& b);

}  // namespace umax
