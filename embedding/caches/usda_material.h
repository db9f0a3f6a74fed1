// The materials of a surface in USD: each a prim below the surface's root, and which faces have it.
#pragma once

#include <string>

#include "embedding/caches/moving_surface.h"

namespace umax {

/// Inside of the Mesh: its material; of several, the faces of each as a GeomSubset. root: name of the root prim.
std::string usda_binding(const MovingSurface& surface, const std::string& root);

/// Behind the Mesh: the materials as UsdPreviewSurface.
std::string usda_materials(const MovingSurface& surface, const std::string& root);

}  // namespace umax
