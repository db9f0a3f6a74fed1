#include "tools/python/body_values.h"

#include <vector>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "scenes/scene_document.h"

namespace umax {

std::size_t find_body(const Simulation& simulation, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < simulation.bodies.size(); ++b) {
    names.push_back(simulation.bodies[b].name);
    if (names.back() == name) return b;
  }
  if (name.empty() && names.size() == 1) return 0;
  throw Error(Fault::bad_data, {.where = "body",
                                .what = name.empty() ? "must be named, as there are several" : "there is no such body",
                                .value = name,
                                .remedy = name.empty() ? "name one of " + list_text(names)
                                                       : "did you mean " + nearest_word(name, names) + "?"});
}

Points points_of_body(const Simulation& simulation, const State& state, std::size_t body, BodyPoints quantity) {
  const BodySetup& setup = simulation.bodies[body];
  const Points& all = quantity == BodyPoints::velocities ? state.velocities : state.positions;
  const Points nodes = all.middleRows(setup.first_node, setup.lattice.num_nodes());
  return quantity == BodyPoints::surface ? surface_of_body(simulation, body, nodes) : nodes;
}

Points surface_of_body(const Simulation& simulation, std::size_t body, const Points& nodes) {
  const BodySetup& setup = simulation.bodies[body];
  Points surface;
  deform_positions(*setup.embedding, setup.lattice.hexes, nodes, surface);
  return surface;
}

VectorXd energy_ratios_of_body(const Simulation& simulation, const State& state, std::size_t body) {
  const BodySetup& setup = simulation.bodies[body];
  return energy_ratios(simulation.model, simulation.options.solver, state)
      .segment(setup.first_hex, setup.lattice.num_hexes());
}

void add_nodal_forces(const Simulation& simulation, std::size_t body, const Points& forces, Points& all) {
  all.middleRows(simulation.bodies[body].first_node, forces.rows()) += forces;
}

void add_surface_forces(const Simulation& simulation, std::size_t body, const Points& forces, Points& all) {
  const BodySetup& setup = simulation.bodies[body];
  add_nodal_forces(simulation, body,
                   nodal_forces(points_of(*setup.embedding), setup.lattice.hexes, setup.lattice.num_nodes(), forces),
                   all);
}

}  // namespace umax
