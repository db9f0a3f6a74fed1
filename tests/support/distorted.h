// Box lattices whose nodes are moved at random, so that no two hexes are alike; the outline stays the box.
#pragma once

#include "core/model/lattice.h"
#include "tests/support/hex_samples.h"

namespace umax::test {

/// An irregular lattice: every node is moved by up to `share` of a cell along each axis, but stays in the faces, edges
/// and corners of the box that it lies in.
inline Lattice distorted_lattice(const Lattice& box, double share, std::uint64_t seed = 1) {
  Lattice lattice = make_irregular_lattice(box.rest_positions, box.hexes);
  const Vector3d low = box.rest_positions.colwise().minCoeff(), high = box.rest_positions.colwise().maxCoeff();
  Random random(seed);
  for (Eigen::Index node = 0; node < lattice.num_nodes(); ++node) {
    const Vector3d by = share * random.vector(1).cwiseProduct(box.cell_size);
    for (int axis = 0; axis < 3; ++axis) {
      double& x = lattice.rest_positions(node, axis);
      const double margin = 1e-9 * box.cell_size[axis];
      if (x > low[axis] + margin && x < high[axis] - margin) x += by[axis];
    }
  }
  return lattice;
}

}  // namespace umax::test
