#include "core/step/islands.h"

#include <algorithm>
#include <utility>

#include "core/base/groups.h"
#include "core/contact/clearances.h"
#include "core/contact/contact_detection.h"
#include "core/contact/contact_support.h"
#include "core/contact/surface_contact.h"
#include "core/contact/surface_overlap.h"

namespace umax {
namespace {

constexpr double margin = 0.15;  // [cells] that hexes may be apart

// Calls visit(body, first row there, first row in the island, rows) for what `range` says of each body.
struct Rows {
  Eigen::Index first = 0, count = 0;
};
template <class Range, class Visit>
void for_each_part(const Model& model, const Island& island, const Range& range, const Visit& visit) {
  for (std::size_t i = 0; i < island.bodies.size(); ++i)
    visit(range(model, model.bodies[island.bodies[i]]), range(island.model, island.model.bodies[i]));
}

Rows nodes_of(const Model&, const Model::BodyRange& body) {
  return {body.first_node, body.num_nodes};
}
Rows limits_of(const Model& model, const Model::BodyRange& body) {
  const int first = model.limit_starts[body.first_hex];
  return {first, model.limit_starts[body.first_hex + body.num_hexes] - first};
}

// A contact as another numbering has it. from, to: bodies of the same points and hexes.
void renumber(const Model::BodyRange& from, const Model::BodyRange& to, State::ContactImpulse& contact) {
  contact.hex += to.first_hex - from.first_hex;
  if (contact.point.kind != ContactKind::obstacle_edge) contact.point.index += to.first_point - from.first_point;
}

// Encounters at the positions between bodies of different islands; island_of: #B.
std::shared_ptr<Clearances> across(const Model& model, const ContactGeometry& geometry, const Points& positions,
                                   const std::vector<int>& island_of) {
  auto known = std::make_shared<Clearances>();
  known->encounters = find_encounters_of(
      model, geometry.touchable, geometry.hex_starts, positions, encounter_margin,
      [&](int body, int other) { return island_of[std::size_t(body)] != island_of[std::size_t(other)]; });
  return known;
}

}  // namespace

std::vector<std::vector<int>> find_islands(const Model& model, const ContactGeometry& geometry, double time_step,
                                           const State& state) {
  Groups groups(model.bodies.size());
  if (model.bodies.size() < 2 || !geometry.touchable.any()) return groups.all();
  for (const State::ContactImpulse& contact : state.contacts)
    if (contact.other_hex >= 0) groups.join(model.hex_body[contact.hex], model.hex_body[contact.other_hex]);
  const Points expected = state.positions + time_step * state.velocities;
  const Encounters encounters =
      find_encounters_of(model, geometry.touchable, geometry.hex_starts, expected, margin,
                         [&](int body, int other) { return groups.of(body) != groups.of(other); });
  for (const Encounter& encounter : encounters.all) groups.join(model.hex_body[encounter.hex], encounter.body);
  for (const FastPair& pair : fast_pairs(model, geometry.touchable, geometry.hex_starts, state.positions, expected))
    groups.join(pair.body, pair.other);
  return groups.all();
}

std::vector<std::vector<int>> join_islands(const Model& model, const ContactGeometry& geometry, const State& start,
                                           const State& end, const std::vector<std::vector<int>>& islands) {
  if (islands.size() < 2 || !geometry.touchable.any()) return islands;
  std::vector<int> island_of(model.bodies.size());
  Groups groups(model.bodies.size());
  for (std::size_t i = 0; i < islands.size(); ++i)
    for (const int body : islands[i]) {
      island_of[body] = int(i);
      groups.join(islands[i].front(), body);
    }
  const ContactStep step =
      begin_contact_step(model, geometry, start.positions, end.positions, start.time, end.time - start.time, 0,
                         across(model, geometry, end.positions, island_of));
  for (const Contact& contact : surface_candidates(step, LastApart(start.positions), end.positions, 1)) {
    const auto [first, second] = bodies_of(model, contact);
    if (island_of[first] != island_of[second]) groups.join(first, second);
  }
  return groups.all();
}

double deepest_across(const Model& model, const ContactGeometry& geometry, const Points& positions,
                      const std::vector<std::unique_ptr<Island>>& islands) {
  std::vector<int> island_of(model.bodies.size());
  for (std::size_t i = 0; i < islands.size(); ++i)
    for (const int body : islands[i]->bodies) island_of[std::size_t(body)] = int(i);
  return max_surface_penetration(model, geometry, positions, across(model, geometry, positions, island_of));
}

std::unique_ptr<Island> make_island(const Model& model, const ContactGeometry& geometry,
                                    const std::vector<int>& bodies) {
  auto island = std::make_unique<Island>();
  island->bodies = bodies;
  island->model = part_of(model, bodies);
  island->workspace.contact_geometry = part_of(model, geometry, island->model, bodies);
  island->workspace.bodies.resize(bodies.size());
  return island;
}

Points part_of(const Model& model, const Points& points, const Island& island) {
  Points part(points.rows() > 0 ? island.model.num_nodes() : 0, 3);
  if (part.rows() == 0) return part;
  for_each_part(model, island, nodes_of, [&](const Rows& there, const Rows& here) {
    part.middleRows(here.first, here.count) = points.middleRows(there.first, there.count);
  });
  return part;
}

State part_of(const Model& model, const State& state, const Island& island) {
  State part = rest_state(island.model);
  part.time = state.time;
  part.step = state.step;
  part.been_feasible = state.been_feasible;
  for_each_part(model, island, nodes_of, [&](const Rows& there, const Rows& here) {
    part.positions.middleRows(here.first, here.count) = state.positions.middleRows(there.first, there.count);
    part.velocities.middleRows(here.first, here.count) = state.velocities.middleRows(there.first, there.count);
  });
  for_each_part(model, island, limits_of, [&](const Rows& there, const Rows& here) {
    part.limit_multipliers.segment(here.first, here.count) = state.limit_multipliers.segment(there.first, there.count);
  });
  std::vector<int> place(model.bodies.size(), -1);
  for (std::size_t i = 0; i < island.bodies.size(); ++i) place[island.bodies[i]] = int(i);
  for (State::ContactImpulse contact : state.contacts) {
    const int body = model.hex_body[contact.hex];
    if (place[body] < 0) continue;
    if (contact.other_hex >= 0) {
      const int other = model.hex_body[contact.other_hex];
      contact.other_hex += island.model.bodies[place[other]].first_hex - model.bodies[other].first_hex;
    }
    renumber(model.bodies[body], island.model.bodies[place[body]], contact);
    part.contacts.push_back(contact);
  }
  return part;
}

void put_back(const Model& model, const Island& island, const State& part, State& state) {
  for_each_part(model, island, nodes_of, [&](const Rows& there, const Rows& here) {
    state.positions.middleRows(there.first, there.count) = part.positions.middleRows(here.first, here.count);
    state.velocities.middleRows(there.first, there.count) = part.velocities.middleRows(here.first, here.count);
  });
  for_each_part(model, island, limits_of, [&](const Rows& there, const Rows& here) {
    state.limit_multipliers.segment(there.first, there.count) = part.limit_multipliers.segment(here.first, here.count);
  });
  for (State::ContactImpulse contact : part.contacts) {
    const int here = island.model.hex_body[contact.hex];
    if (contact.other_hex >= 0) {
      const int other = island.model.hex_body[contact.other_hex];
      contact.other_hex += model.bodies[island.bodies[other]].first_hex - island.model.bodies[other].first_hex;
    }
    renumber(island.model.bodies[here], model.bodies[island.bodies[here]], contact);
    state.contacts.push_back(contact);
  }
}

}  // namespace umax
