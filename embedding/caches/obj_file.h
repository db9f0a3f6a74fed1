// Wavefront OBJ: a surface in one pose, with texture coordinates, vertex colours, its name and its materials.
#pragma once

#include <string>

#include "embedding/caches/moving_surface.h"

namespace umax {

/// The file that holds the surface with these positions, with the name of its materials' library.
std::string obj_text(const MovingSurface& surface, const FloatPoints& positions);

/// That library, a .mtl file.
std::string mtl_text(const MovingSurface& surface);

}  // namespace umax
