// Parts of one body that move far against each other: a limb that hits its own body faster than is seen step by step.
//
// Motion of a hex  m = R^T (c1 - C1) + C0 - c0
//
// c0, c1: its centre at both positions [m];  C0, C1: the body's centre of mass [m]
// R: the body's rotation in between: what turns or flies as a whole does not move against itself
#pragma once

#include <vector>

#include "core/contact/encounters.h"

namespace umax {

/// Bodies that may touch themselves of which hexes without a common node may meet on straight ways between two sets of
/// positions, and move farther against each other than felt_motion; in their order.
std::vector<FastPair> fast_parts(const Model& model, const TouchableBodies& touchable,
                                 const std::vector<int>& hex_starts, const Points& from, const Points& to);

}  // namespace umax
