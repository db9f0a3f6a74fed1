// Vertices of a mesh file that no triangle has: they have no part in the physics, and go with the cage.
//
// inside of a hex   as the surface does (embedding.h)
// outside           rigidly with the hex whose centre is nearest at rest:  x = c + R (p - c_rest)
//
// p, x: the vertex at rest and now [m];  c_rest, c: the hex's centre at rest and now [m];  R: its rotation there
#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/model/embedded_points.h"
#include "core/model/lattice.h"

namespace umax {

struct LooseVertices {
  std::vector<Eigen::Index> inside, outside;  // rows of the points that were tied; together all
  EmbeddedPoints embedded;                    // of those inside
  std::vector<int> nearest_hex;               // of those outside
  Points offset;                              // #outside x 3 from that hex's centre at rest [m]

  Eigen::Index size() const { return Eigen::Index(inside.size() + outside.size()); }
};

/// Ties points, #P x 3 [m] at rest, to a lattice that is at rest. Of hexes that are equally near the one with the lowest
/// index.
LooseVertices tie_loose_vertices(const Points& points, const Lattice& lattice);

/// Where they are for node positions (#N x 3 [m]): #P x 3 [m].
Points deform_loose_vertices(const LooseVertices& loose, const Lattice& lattice, const Points& nodes);

}  // namespace umax
