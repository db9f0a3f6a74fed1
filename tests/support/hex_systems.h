// Cages with turned and stiffened hexes, as a matrix-free operator and as an assembled matrix.
#pragma once

#include <string>
#include <vector>

#include "core/linear/bricks/hex_operator.h"
#include "core/linear/direct/system_matrix.h"
#include "core/model/model.h"
#include "tests/support/hex_samples.h"

namespace umax::test {

struct HexSystem {
  std::string name;
  Lattice lattice;
  BrickLattice bricks;
  HexShape shape;
  std::vector<int> cell_slots, node_slots;
  std::vector<Matrix3d> rotations;  // #E
  VectorXd stiffness;               // #E [Pa] multiplier times Young's modulus
  VectorXd diagonal;                // #N [N/m]
  std::vector<char> fixed;          // #N
  SystemMatrix assembled;

  template <class S>
  HexMatrix<S> matrix() const;
  /// Uniform in [-1, 1], zero at fixed nodes.
  VectorXd random_vector(Random& random) const;
};

struct HexSystemOptions {
  std::string name;
  Cells cells;
  Vector3d cell_size{0.1, 0.1, 0.1};  // [m]
  double poisson = 0.3;
  double young = 500e3;                // [Pa]
  double inverse_time_squared = 3600;  // [1/s^2]
  double turn = 0;                     // 1: any rotation; 0: none; between: random ones of up to that share of pi
  double bend = 0;                     // [rad] by which the hexes turn about y from one end of the cage to the other
  std::vector<double> multipliers{1};  // each hex takes one of them at random
  bool fix_low_x = false;              // clamps the nodes of lowest x
  double share_fixed = 0;              // of all nodes, at random
};

HexSystem make_hex_system(const HexSystemOptions& options);

Cells box_cells(const Vector3i& size);
/// Without a share of its cells, taken out at random.
Cells with_holes(const Cells& cells, double share, Random& random);

/// For tests of the operator: holes, rods along each axis, islands, flat cells, several bricks.
std::vector<HexSystem> hex_systems();

}  // namespace umax::test
