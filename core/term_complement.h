// What couples the multipliers of terms in a smoothing step, the Schur complement
//
//   S = C + w G^T D^-1 G,   C: diagonal; D: 3 x 3 diagonal blocks of A
// It has entries for hexes that share a node. Where multipliers hold each other in balance along a line of hexes it is
// nearly singular.
#pragma once

#include <vector>

#include "core/hex_terms.h"
#include "core/multigrid.h"
#include "core/supernodal_factor.h"

namespace umax {

struct TermComplement {
  // S without its diagonal, scaled so that this is one, in slices of 16 rows: their first entries, their second ones
  // ... Shorter rows are filled up with zeros. scale: 1 / sqrt(S_ii)
  std::vector<std::size_t> slice_starts;
  std::vector<int> columns;
  std::vector<float> values;
  VectorXf scale;
  float largest = 1;                           // no eigenvalue of the scaled S is larger
  std::vector<HexTerms::Vector24f> responses;  // w D^-1 g of each term
  bool is_factored = false;
  SupernodalFactor factor;  // of the scaled S
};

/// For terms on the level's lattice, whose matrix and inverse are known; own: C.
void set_up(const MultigridLevel& level, const HexTerms& terms, const VectorXf& own, float w, TermComplement& S);

/// S^-1 b, where terms are many nearly: a few steps of Chebyshev's iteration.
VectorXf solve(const TermComplement& S, const VectorXf& b);

}  // namespace umax
