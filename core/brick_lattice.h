// A regular lattice stored in bricks (core/brick.h), only those that have nodes: what the matrix-free operator runs on.
#pragma once

#include <cstdint>
#include <vector>

#include "core/brick.h"
#include "core/types.h"

namespace umax {

struct BrickLattice {
  std::vector<Brick> bricks;              // sorted by place, x slowest; the first is empty and stands for none
  std::vector<int> column_starts;         // first brick of each column along z, and the end
  std::vector<std::uint16_t> cell_masks;  // 64 per brick: bit k of line 8 i + j is set where there is a cell
  std::vector<std::uint16_t> node_masks;  // likewise
  Vector3i first_cell{0, 0, 0};           // grid coordinates of what is (0, 0, 0) here
  Vector3d cell_size{0, 0, 0};            // [m]
  Eigen::Index num_cells = 0, num_nodes = 0;

  int num_columns() const { return int(column_starts.size()) - 1; }
  std::size_t num_slots() const { return bricks.size() * brick_slots; }
};

/// Bricks of the given grid cells (any order, no duplicates).
BrickLattice make_brick_lattice(const Cells& cells, const Vector3d& cell_size);

/// The lattice whose cells are made of `factor` (1 or 2 along each axis) cells of a finer one.
BrickLattice coarsen(const BrickLattice& fine, const Vector3i& factor);

/// Index of the brick at a place, or 0.
int find_brick(const BrickLattice& lattice, const Vector3i& place);

/// Slot of each cell, and of each node of hexes over these cells (Lattice's order).
std::vector<int> cell_slots(const BrickLattice& lattice, const Cells& cells);
std::vector<int> node_slots(const BrickLattice& lattice, const Cells& cells, const Hexes& hexes,
                            Eigen::Index num_nodes);

/// First component of a slot's values in an array of `components` per slot; the others follow brick_lanes apart.
inline std::size_t slot_offset(int slot, int components) {
  return std::size_t(slot / brick_lanes) * components * brick_lanes + slot % brick_lanes;
}

/// Calls body(first, last) for blocks of whole columns' bricks in parallel and returns the sum of body's results over
/// the columns, in their order.
double sum_over_columns(const BrickLattice& lattice, double (*body)(const void* context, int first, int last),
                        const void* context);

template <class Body>
double for_each_column(const BrickLattice& lattice, const Body& body) {
  return sum_over_columns(
      lattice,
      [](const void* context, int first, int last) -> double {
        return (*static_cast<const Body*>(context))(first, last);
      },
      &body);
}

}  // namespace umax
