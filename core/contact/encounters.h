// Which hexes may touch in a step: those whose boxes, grown by a margin, meet where the bodies are expected at its end.
#pragma once

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

/// How far hexes of different bodies that may touch come towards each other between two sets of positions [cells of the smaller ones]: the
/// largest relative motion of two hexes' centres among those whose paths' boxes meet. 0 where no two nodes move more than
/// `enough` against each other.
double largest_approach(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                        const Points& from, const Points& to, double enough);

}  // namespace umax
