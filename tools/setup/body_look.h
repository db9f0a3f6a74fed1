// How a body is drawn: by what the scene says, and else by the materials of its mesh file.
#pragma once

#include "tools/setup/body_shape.h"

namespace umax {

/// The scene's look with its pictures read. Where the scene asks for no colour, vertices or materials of the file have
/// their own; textures multiply either. A picture that cannot be read is a warning, and the plain colour.
Look body_look(const BodyDescription& body, const PlacedMesh& shape, ShapeLibrary& library,
               std::vector<std::string>& warnings);

/// The look as it can be drawn: light enters closed surfaces only; of others what lies below stays matt, and a note says
/// so. mesh: null is a plane.
Look drawable_look(Look look, const TriangleMesh* mesh, std::vector<std::string>& notes);

}  // namespace umax
