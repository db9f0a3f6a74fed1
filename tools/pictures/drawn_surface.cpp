#include "tools/pictures/drawn_surface.h"

#include <algorithm>

#include "embedding/smooth_surface.h"

namespace umax {
namespace {

bool is_smooth(const Simulation& simulation, const BodySetup& body) {
  return simulation.scene.render.surface == SurfaceKernel::smooth && body.lattice.is_regular();
}

}  // namespace

void draw_surface(const Simulation& simulation, const BodySetup& body, const Points& nodes, TriangleMesh& out) {
  if (is_smooth(simulation, body))
    deform_smoothly(*body.embedding, body.lattice, nodes, out);
  else
    deform(*body.embedding, body.lattice.hexes, nodes, out);
}

double departure_of_surface(const Simulation& simulation, const Points& nodes) {
  double largest = 0;
  for (const BodySetup& body : simulation.bodies) {
    if (!is_smooth(simulation, body)) continue;
    const Points own = nodes.middleRows(body.first_node, body.lattice.num_nodes());
    Points trilinear;
    deform_positions(*body.embedding, body.lattice.hexes, own, trilinear);
    const Points smooth = smooth_positions(body.embedding->hex, body.embedding->local, body.lattice, own);
    if (smooth.rows() > 0) largest = std::max(largest, (smooth - trilinear).rowwise().norm().maxCoeff());
  }
  return largest;
}

}  // namespace umax
