// The cage that comes as a mesh of hexes, instead of being made by voxelize().
#pragma once

#include "core/lattice.h"
#include "embedding/voxelize.h"

namespace umax {

/// [m^3] of every hex.
VectorXd hex_volumes(const Lattice& lattice);

struct HexCageOptions {
  bool is_the_body = false;  // the surface is the hexes' own: all of them are full
  int samples = 6;           // [-] along each axis of a hex, for the share of it inside the surface
};

/// Irregular lattice of the hexes with the share of each inside the surface, to about 1 % for a hex that it cuts.
/// Throws Error (bad_data) for hexes that validate() refuses.
Lattice make_hex_cage(const TriangleMesh& surface, const Points& nodes, const Hexes& hexes,
                      const HexCageOptions& options, CageReport* report = nullptr);

}  // namespace umax
