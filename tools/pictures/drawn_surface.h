// Where a body's surface is drawn: in its cage by trilinear weights, or without the creases of those (render.surface).
#pragma once

#include "tools/setup/simulation_setup.h"

namespace umax {

/// Places and normals of the body's surface for nodes of its own cage, #N x 3 [m].
void draw_surface(const Simulation& simulation, const BodySetup& body, const Points& nodes, TriangleMesh& out);

/// How far the drawn surface is from that which physics knows, at most, over all bodies [m]. nodes: the model's.
double departure_of_surface(const Simulation& simulation, const Points& nodes);

}  // namespace umax
