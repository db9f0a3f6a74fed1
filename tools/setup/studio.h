// Ground, lights and sky for bodies that come without a scene, in proportion to their size.
#pragma once

#include "scenes/scene.h"

namespace umax {

/// Adds a ground at height `floor`, a key light, a rim light and a sky for something `height` [m] tall.
void add_studio(Scene& scene, double height, double floor);

/// Smooth and a little glossy; clay for a mesh without colours of its own.
Look studio_look(bool has_own_colors);

}  // namespace umax
