// What a script reads of a body in a state: nodes, velocities, surface, energies.
#pragma once

#include <string>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// Quantities that have one row of 3 for each node or vertex.
enum class BodyPoints {
  positions,   // #N x 3 [m] of nodes
  velocities,  // #N x 3 [m/s] of nodes
  surface,     // #V x 3 [m] of the mesh's vertices, in the order of its file
};

/// The body's place in the simulation; "" is the only one. Throws Error (bad_data) that names the bodies there are.
std::size_t find_body(const Simulation& simulation, const std::string& name);

Points points_of_body(const Simulation& simulation, const State& state, std::size_t body, BodyPoints quantity);

/// The surface for other positions of the body's nodes, #N x 3 [m]: #V x 3 [m].
Points surface_of_body(const Simulation& simulation, std::size_t body, const Points& nodes);

/// U/U_max [-] of each hex's worst limit, 0 where it has none: #E.
VectorXd energy_ratios_of_body(const Simulation& simulation, const State& state, std::size_t body);

/// Forces on a body's nodes or on its surface's vertices [N] as they reach the model's nodes, added to those of the model,
/// which has one row for each node.
void add_nodal_forces(const Simulation& simulation, std::size_t body, const Points& forces, Points& all);
void add_surface_forces(const Simulation& simulation, std::size_t body, const Points& forces, Points& all);

}  // namespace umax
