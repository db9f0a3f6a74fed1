// Which hexes may touch in a step: those whose boxes, grown by a margin, meet where the bodies are expected at its end.
#pragma once

#include <utility>
#include <vector>

#include "core/contact/hex_tree.h"
#include "core/contact/material_point.h"

namespace umax {

/// Which bodies' vertices may touch which bodies' surfaces; constant during a run.
struct TouchableBodies {
  std::vector<std::vector<int>> surfaces;  // per body: the bodies whose surface its vertices may touch, ascending
  std::vector<HexTree> trees;              // per body; none where nothing may touch it
  bool any() const;
};
TouchableBodies find_touchable(const Model& model);

/// Do two hexes have a node in common?
bool share_node(const Model& model, int a, int b);

/// A hex with surface vertices, and the hexes of one body that these may come into.
struct Encounter {
  int hex = 0, body = 0;
  std::vector<int> others;  // ascending; none that shares a node with the hex
};

/// bound_hex() of every hex of bodies that something may touch; of others as it is made: #E.
std::vector<HexBounds> bound_hexes(const Model& model, const TouchableBodies& touchable, const Points& positions);

struct Encounters {
  Points expected;             // #N x 3 [m] positions that they were found at
  std::vector<Encounter> all;  // in the order of hexes and bodies
};

/// hex_starts: #E + 1, the surface vertices of hex e are hex_starts[e] ... hex_starts[e + 1] - 1. margin: [cells], at most 0.15.
Encounters find_encounters(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                           const Points& positions, double margin);

/// Is every node within the margin [cells of its body] of where it was expected?
bool are_complete(const Model& model, const Encounters& encounters, const Points& positions, double margin);

/// [cells of the smaller] that two hexes may move against each other between two looks at what touches: less than their
/// size, so that none passes another unseen.
inline constexpr double felt_motion = 0.5;

/// How many times felt_motion hexes of a body and others that may touch move against each other on straight ways between two
/// sets of positions, at most: of the centres of two hexes whose ways' boxes meet. Per body; 1 where less.
VectorXd largest_approaches(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                            const Points& from, const Points& to);

/// Looks that the way takes: 1 where no two hexes come farther towards each other than felt_motion.
int felt_parts(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
               const Points& from, const Points& to);

/// Pairs of bodies, the smaller first, of which hexes may meet on their ways though they are apart at both ends of them.
std::vector<std::pair<int, int>> fast_pairs(const Model& model, const TouchableBodies& touchable,
                                            const std::vector<int>& hex_starts, const Points& from, const Points& to);

}  // namespace umax
