// What searches remember, also from step to step: how far hexes may still move against a body before a vertex of theirs
// can touch it.
//
// A vertex that is outside a body by a distance c, or outside all of its hexes by c, is still so while the sum of the ways
// that the hexes have moved against each other since, from one search to the next, is below c. So most vertices are
// looked at once, and those of a pile at rest once in many steps. Nothing that is found depends on it.
#pragma once

#include <limits>
#include <vector>

#include "core/contact/encounters.h"
#include "core/contact/vertex_clusters.h"

namespace umax {

struct Clearances {
  struct OfEncounter {
    double way = 0;  // [m] that the hexes have moved against each other, in the world or in the body's material
    std::vector<double>
        until;  // of that, per vertex of the hex in the order of VertexClusters::points: it cannot touch
                // before; empty: nothing is known yet
    double least = -std::numeric_limits<double>::infinity();  // of these, or less
    std::vector<int> unseen;  // hexes of Encounter::others that `until` does not know, ascending
  };
  Points positions;       // #N x 3 [m] of the last search; none yet: empty
  Encounters encounters;  // complete around the positions
  std::vector<OfEncounter> of_encounters;
};

/// Encounters that are complete at the positions: those of bodies that have left the margin [cells] around where they were
/// expected are found anew; all of them where there are none yet. What is known of a hex's vertices against a body stays, and
/// hexes of the body that are new to it are unseen.
void complete(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
              const Points& positions, double margin, Clearances& clearances);

/// Adds the ways of hexes from the last search to one at the positions. bounds: as of bound_hexes() there.
void advance(const Model& model, const std::vector<HexBounds>& bounds, const Points& positions, Clearances& clearances);

}  // namespace umax
