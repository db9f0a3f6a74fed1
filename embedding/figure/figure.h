// The project's own character, "figure": a small armoured biped made without any model file, from signed distances.
#pragma once

#include "core/base/triangle_mesh.h"

namespace umax {

struct FigureOptions {
  double height = 2.0;       // [m] from the soles on y = 0 to the tips of the ears
  double cell_size = 10e-3;  // [m] of a 2 m tall figure: edge length of the triangles; raising it makes a coarser mesh
};

/// The character standing on y = 0, facing +z, centred on x = 0: one closed, manifold surface seen counter-clockwise
/// from outside, with unit vertex normals and vertex colours (linear Rec. 709). The same bytes for any number of
/// threads. Throws Error (bad_data) when the height is not positive or the cell size is outside 4 mm .. 20 mm.
TriangleMesh make_figure(const FigureOptions& options = {});

}  // namespace umax
