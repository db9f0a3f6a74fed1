// Polygons of files cut into triangles.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// Cuts a polygon along diagonals that lie within it, as seen along its mean normal; where there is none left (it
/// crosses itself, or lies on a line) as a fan. corners: rows of positions, which must exist. Appends three places in
/// `corners` for each triangle.
void cut_polygon(const Points& positions, const std::vector<int>& corners, std::vector<std::array<int, 3>>& triangles);

}  // namespace umax
