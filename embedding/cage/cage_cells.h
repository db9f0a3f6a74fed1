// Which cells of a grid make the cage of a surface: those that it passes through and those inside it.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"
#include "embedding/surface/solid.h"

namespace umax {

struct CageGrid {
  Vector3d origin{0, 0, 0};     // [m] corner of cell (0, 0, 0)
  Vector3d cell_size{0, 0, 0};  // [m]
  Vector3i size{0, 0, 0};       // cells along each axis
};

using Cell = std::array<int, 3>;
struct CageCells {
  std::vector<Cell> cells;    // sorted
  std::vector<char> touched;  // per cell: the surface passes through
};

/// Cells of the grid that the solid's mesh (the triangles without its caps) touches or fills. A face that lies in a
/// grid plane belongs to the filled cell beside it, or to the lower one if neither is filled.
CageCells cage_cells(const Solid& solid, const Points& positions, const Triangles& triangles, const CageGrid& grid);

}  // namespace umax
