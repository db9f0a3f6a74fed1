// How the terms of different hexes depend on each other, which the Schur complement of the saddle-point system holds:
//
//   S = I + G^T A^-1 G  ~  P = I + G^T D^-1 G,   D: 3 x 3 diagonal blocks of A
// P couples only hexes that share a node, and is factored. It sees what no hex sees by itself: limits along a load
// hardly give way to forces that differ from row to row. With P alone smooth forces seem to do too little;
//
//   S^-1 ~ P^-1 (I + G^T D^-1 A D^-1 G) P^-1      Elman, Howle, Shadid, Shuttleworth, Tuminaro 2006
// sees them too. On a falling body of 8000 hexes, 2051 limits: the largest eigenvalue of the product with S over the
// smallest is 243 with one block per hex, 169 with P, 11 with both.
#pragma once

#include "core/hex_terms.h"
#include "core/supernodal_factor.h"

namespace umax {

struct TermCoupling {
  bool exists = false;
  SupernodalFactor factor;  // of P
};

/// Factors P; inverse: D^-1 in bricks. Without terms, or where the factor would take more than it saves, there is no
/// coupling.
TermCoupling make_term_coupling(const HexTerms& terms, const AlignedArray<float>& inverse);

}  // namespace umax
