// Look-up in a regular lattice: from grid coordinates to the hex there, and from a point to the hexes that hold it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/model/lattice.h"

namespace umax {

/// A point this close to a grid plane, as a share of the cell's edge, lies in the cells on both sides of it.
inline constexpr double face_tolerance = 1e-9;

/// Lowest and highest cell, along one axis, that holds the grid coordinate s = (x - origin) / cell_size.
std::pair<int, int> cells_at(double s);

class CellTable {
 public:
  /// The lattice's cells must be sorted, as make_lattice() leaves them.
  explicit CellTable(const Cells& cells);

  /// Index of the hex at grid coordinates (i, j, k), or -1.
  int find(int i, int j, int k) const;

  /// Lowest hex that holds the point with grid coordinates s, or -1.
  int find(const Vector3d& s) const;

 private:
  bool inside_box(int i, int j, int k) const;

  Vector3i low_{0, 0, 0}, size_{0, 0, 0};
  std::vector<int> dense_;          // hex or -1; empty when the box is too large for it
  std::vector<std::int64_t> keys_;  // otherwise: sorted linear indices of the cells
};

}  // namespace umax
