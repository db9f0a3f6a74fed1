// Ground, lights and sky for bodies that come without a scene, in proportion to their size.
#pragma once

#include "scenes/scene.h"

namespace umax {

/// Adds a ground at height `floor`, a key light, a rim light and a sky for something `height` [m] tall, and colours
/// its bodies.
void add_studio(Scene& scene, double height, double floor);

}  // namespace umax
