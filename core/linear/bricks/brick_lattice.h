// A regular lattice of cells and nodes in bricks (core/linear/bricks/brick.h), of which only those are stored that have
// nodes: what the matrix-free operator runs on.
//
// A slot numbers one node or cell: 1024 brick + 16 (8 i + j) + k.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/linear/bricks/brick.h"

namespace umax {

struct BrickLattice {
  std::vector<Brick> bricks;              // sorted by place, x slowest; the first is empty and stands for none
  std::vector<int> column_starts;         // first brick of each column along z, and the end
  std::vector<BrickRun> runs;             // of the sweeps' tasks, in each from the lowest z to the highest
  std::vector<int> task_starts;           // first run of each task, and the end
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

/// Corner n of a cell, from its first.
inline Vector3i corner(int n) {
  return {n >> 2 & 1, n >> 1 & 1, n & 1};
}

/// What corner m of a coarse cell weighs at a point of the finer lattice, 0 ... factor from the cell's first corner.
inline double coarse_weight(const Vector3i& point, const Vector3i& factor, int m) {
  double weight = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = double(point[axis]) / factor[axis];
    weight *= corner(m)[axis] ? along : 1 - along;
  }
  return weight;
}

/// Index of the brick at a place, or 0.
int find_brick(const BrickLattice& lattice, const Vector3i& place);

/// Slot of a point, from first_cell; in brick 0 where its brick is not stored.
int slot_of(const BrickLattice& lattice, const Vector3i& point);

/// Where a slot stands in its brick: [0, 8) x [0, 8) x [0, 16).
inline Vector3i place_in_brick(int slot) {
  const int line = slot / brick_lanes % brick_lines;
  return {line / brick_edge, line % brick_edge, slot % brick_lanes};
}

/// Slot of the point `step` (-1 .. 2 along each axis) from that in a slot; -1: in no brick.
int slot_near(const BrickLattice& lattice, int slot, const Vector3i& step);

/// Slots of the nodes of the cell in a slot.
inline std::array<int, 8> corner_slots(const BrickLattice& lattice, int cell) {
  std::array<int, 8> nodes{};
  for (int n = 0; n < 8; ++n) nodes[n] = slot_near(lattice, cell, corner(n));
  return nodes;
}

/// Slot of each cell, and of each node of hexes over these cells (Lattice's order).
std::vector<int> cell_slots(const BrickLattice& lattice, const Cells& cells);
std::vector<int> node_slots(const BrickLattice& lattice, const Cells& cells, const Hexes& hexes,
                            Eigen::Index num_nodes);

/// First component of a slot's values in an array of `components` per slot; the others follow brick_lanes apart.
inline std::size_t slot_offset(int slot, int components) {
  return std::size_t(slot / brick_lanes) * components * brick_lanes + slot % brick_lanes;
}

/// Calls body(task) for tasks 0 .. num_tasks - 1 in parallel, `grain` at a time, and returns the sum of the results in
/// the tasks' order: the same for any number of threads.
double sum_over_tasks(int num_tasks, int grain, double (*body)(const void* context, int task), const void* context);

/// Calls body(first, last), which returns a double, for each column's bricks in parallel, about as many at a time as are
/// said; the sum over the columns.
template <class Body>
double for_each_column(const BrickLattice& lattice, const Body& body, int bricks_per_block = 8) {
  struct Context {
    const BrickLattice& lattice;
    const Body& body;
  } const context{lattice, body};
  const int grain = std::max(1, lattice.num_columns() * bricks_per_block / std::max(1, int(lattice.bricks.size()) - 1));
  return sum_over_tasks(
      lattice.num_columns(), grain,
      [](const void* given, int column) -> double {
        const Context& c = *static_cast<const Context*>(given);
        return c.body(c.lattice.column_starts[column], c.lattice.column_starts[column + 1]);
      },
      &context);
}

/// Calls body(first, last), which returns a double, for each sweep task's runs in parallel; the sum over the tasks.
template <class Body>
double for_each_sweep_task(const BrickLattice& lattice, const Body& body) {
  struct Context {
    const BrickLattice& lattice;
    const Body& body;
  } const context{lattice, body};
  return sum_over_tasks(
      int(lattice.task_starts.size()) - 1, 1,
      [](const void* given, int task) -> double {
        const Context& c = *static_cast<const Context*>(given);
        const BrickRun* runs = c.lattice.runs.data();
        return c.body(runs + c.lattice.task_starts[task], runs + c.lattice.task_starts[task + 1]);
      },
      &context);
}

}  // namespace umax
