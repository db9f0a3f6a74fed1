// Which hexes may touch in a step: those whose boxes, grown by a margin, meet where the bodies are expected at its end.
#pragma once

#include <functional>
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

/// bound_hex() of each hex that one of the encounters meets; of others as it is made: #E.
std::vector<HexBounds> bound_hexes(const Model& model, const std::vector<Encounter>& encounters,
                                   const Points& positions);

struct Encounters {
  Points expected;             // #N x 3 [m] positions that they were found at
  std::vector<Encounter> all;  // in the order of hexes and bodies
};

/// hex_starts: #E + 1, the surface vertices of hex e are hex_starts[e] ... hex_starts[e + 1] - 1. margin: [cells], at most 0.15.
Encounters find_encounters(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                           const Points& positions, double margin);

/// The bodies of which a node is farther than the margin [cells] from where it was expected: #B.
std::vector<char> left_margin(const Model& model, const Encounters& encounters, const Points& positions, double margin);

/// Whether encounters of a body's vertices with another body, or with itself, are wanted.
using WantedBodies = std::function<bool(int body, int other)>;
/// Those alone that are wanted.
Encounters find_encounters_of(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                              const Points& positions, double margin, const WantedBodies& wanted);

/// [cells of the smaller] that two hexes may move against each other between two looks at what touches: less than their
/// size, so that none passes another unseen.
inline constexpr double felt_motion = 0.5;

/// Two bodies of which hexes may meet on straight ways between two sets of positions, though they are apart at both ends.
struct FastPair {
  int body = 0, other = 0;  // vertices of the first, surface of the second; its own, of a body with fast parts
  double approach = 0;      // times felt_motion: of the centres of two hexes whose ways' boxes meet, at most
};

/// Of bodies that may touch and move farther against each other than felt_motion, and of such parts of one
/// (core/contact/fast_parts.h); in the order of bodies.
std::vector<FastPair> fast_pairs(const Model& model, const TouchableBodies& touchable,
                                 const std::vector<int>& hex_starts, const Points& from, const Points& to);

/// FastPair::approach of the fastest pair that a body is in: #B; 1 where none is faster.
VectorXd largest_approaches(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                            const Points& from, const Points& to);

}  // namespace umax
