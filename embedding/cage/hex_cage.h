// The cage that comes as a mesh of hexes, instead of being made by voxelize().
#pragma once

#include "core/model/lattice.h"
#include "embedding/cage/voxelize.h"

namespace umax {

/// [m^3] of every hex.
VectorXd hex_volumes(const Lattice& lattice);

/// Midpoints of an even grid in a hex's own coordinates, per_axis^3 of them.
struct HexSamples {
  Points points;     // #P x 3 [m]
  VectorXd weights;  // #P [m^3] that each stands for, to a common factor
};
HexSamples sample_hex(const Matrix8x3d& nodes, int per_axis);

struct HexCageOptions {
  bool is_the_body = false;  // the surface is the hexes' own: all of them are full
  int samples = 6;           // [-] along each axis of a hex, for the share of it inside the surface
};

/// Irregular lattice of the hexes with the share of each inside the surface, to about 1 % for a hex that it cuts.
/// Throws Error (bad_data) for hexes that validate() refuses.
Lattice make_hex_cage(const TriangleMesh& surface, const Points& nodes, const Hexes& hexes,
                      const HexCageOptions& options, CageReport* report = nullptr);

}  // namespace umax
