// The points by which a body touches: its mesh's vertices, and more where they are far apart beside its cage's cells.
#pragma once

#include "tools/setup/simulation_setup.h"

namespace umax {

/// Points on a body's border (where it has none, on its mesh), in its lattice: no farther than a quarter cell from each
/// other, and closer on ridges. Points outside the cage, as on faces that bulge out of one from a file, are left out.
EmbeddedPoints points_between_vertices(const BodySetup& setup, const Body& body);

/// Appends the points behind the others.
void append(const EmbeddedPoints& points, EmbeddedPoints& all);

}  // namespace umax
