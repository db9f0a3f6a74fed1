// How much of each cell of a cage lies inside the solid, as a share of its volume.
#pragma once

#include "embedding/cage/cage_cells.h"

namespace umax {

/// One number in [0, 1] per cell; untouched cells are 1 (or 0 where they lie outside). Winding numbers: exact along z
/// on 16 x 16 lines a cell; level set: 8 x 8 x 8 distances a cell.
VectorXd filled_fractions(const Solid& solid, const CageGrid& grid, const CageCells& cells);

}  // namespace umax
