// How thin a closed surface's walls are: what a grid of distances has to tell apart.
#pragma once

#include "core/model/rest_surface.h"

namespace umax {

/// Thickness [m] that all walls but a fiftieth of the surface's area have, which may be the tips of wedges; infinity
/// where they are thicker than `reach` [m]. Measured at each triangle's centre, to what faces the other way behind it.
double wall_thickness(const RestSurface& surface, double reach);

}  // namespace umax
