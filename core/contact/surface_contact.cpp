#include "core/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/contact/contact_support.h"
#include "core/contact/held_vertex.h"
#include "core/contact/material_point.h"
#include "core/contact/meeting.h"

namespace umax {
namespace {

constexpr double same_plane = 0.99;  // [-] cosine between normals
constexpr double least_turn = 1e-3;  // [-] of a normal between iterates, that counts
constexpr double kept_share = 0.5;   // [penetration tolerances] that a kept plane may be off the surface

void take(const ContactStep& step, const Points& positions, const HeldVertex& held, const Touch& touch,
          Contact& contact) {
  const AllowedDepth allowed = allowance(step, held);
  contact.other = held.other;
  contact.normal = touch.normal;
  contact.gap = touch.gap + allowed.deep + allowed.shallow;
  // what is pushed out of an overlap slides: friction would hold a body by its sides
  const bool slides = allowed.deep > 0 || leaving_of(step, contact.support.hex, contact.other.hex);
  contact.friction = slides ? 0
                            : friction_between(*step.model, step.model->hex_body[contact.support.hex],
                                               step.model->hex_body[contact.other.hex]);
  contact.position = contact_position(*step.model, positions, contact);
}

// the vertex of an encounter's hex that is deepest in the body, of those deeper than `share` of what is tolerated
std::optional<Contact> deepest_vertex(const Search& search, const LastApart& apart, std::size_t i, double share) {
  const Model& model = *search.step.model;
  const Encounter& encounter = search.clearances.encounters.all[i];
  const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
  const DeepestVertex deepest = find_deepest(meet(search, apart, i), -share * tolerance,
                                             [&](const HeldVertex& held) { return allowance(search.step, held).deep; });
  if (deepest.point < 0) return {};
  Contact contact = make_surface_contact(model, deepest.point, encounter.hex, deepest.held.other.hex);
  take(search.step, search.positions, deepest.held, deepest.touch, contact);
  return contact;
}

bool undoes(const Vector3d& turn, const Vector3d& before) {
  return turn.norm() > least_turn && before.norm() > least_turn &&
         turn.dot(before) < -0.5 * turn.norm() * before.norm();
}

// The contact at its next place, or with its plane there. A vertex that slides to and fro between faces of nearly one plane
// is held by one of them: gaps now of the one, now of the other would keep it going. So would a look away in between: a
// fingertip that leaves a limb on one side comes back to it on the other. One that is in a thin part now, come in from its
// other side, is held on that side: the plane that it had would pull it through. And one that is outside lets go of a plane that
// would push it in.
void move_on(const Model& model, const Points& positions, const Contact& next, Contact& contact) {
  const Vector3d turn = contact.normal.isZero(0) ? Vector3d(0, 0, 0) : Vector3d(next.normal - contact.normal);
  if (!keeps_plane(contact) && undoes(turn, contact.turn)) ++contact.turns_back;
  const Vector3d last_turn = turn.norm() > least_turn ? turn : contact.turn;  // that counts
  contact.turn = last_turn;
  const double tolerance = tolerance_depth(model, next);
  const bool came_in_behind = leave_no_room(contact, next) && next.gap < std::min(-tolerance, contact.gap);
  const bool is_pushed_in = next.gap > 0 && contact.gap < -tolerance && next.normal.dot(contact.normal) < 0;
  if (keeps_plane(contact) && next.gap <= nearly_outside * tolerance && !came_in_behind && !is_pushed_in) {
    keep_at_vertex(model, positions, contact);
    if (next.normal.dot(contact.normal) > same_plane && std::abs(next.gap - contact.gap) > kept_share * tolerance)
      contact.gap = next.gap;
    return;
  }
  const int turns_back = contact.turns_back;
  contact = next;
  contact.turn = last_turn;
  contact.turns_back = turns_back;
}

}  // namespace

std::vector<Contact> surface_candidates(const ContactStep& step, const LastApart& apart, const Points& positions,
                                        double share) {
  if (!step.surfaces_touch || !step.geometry->touchable.any()) return {};
  const Search search = search_at(step, positions);
  std::vector<std::optional<Contact>> deepest(search.clearances.encounters.all.size());
  for_each_encounter(search,
                     [&](std::size_t i, const Encounter&) { deepest[i] = deepest_vertex(search, apart, i, share); });
  std::vector<Contact> all;
  for (const std::optional<Contact>& contact : deepest)
    if (contact) all.push_back(*contact);
  return all;
}

bool bodies_meet(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                 bool counts_own) {
  const std::vector<Contact> contacts = surface_candidates(step, apart, positions, share);
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    const auto [first, second] = bodies_of(*step.model, contact);
    return counts_own || first != second;
  });
}

void place_surface_contacts(const ContactStep& step, const LastApart& apart, const Points& positions,
                            std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  std::vector<std::vector<Eigen::AlignedBox3d>> boxes;  // made when the first vertex has left its hex
  for (Contact& contact : contacts) {
    if (!contact.between_bodies()) continue;
    const Support& vertex = contact.support;
    const Vector3d position = embedded_position(model, positions, vertex);
    const int body = model.hex_body[contact.other.hex];
    const Points& before = apart.of(vertex.hex, body);
    HeldVertex held;
    const HexMaps last = hex_maps(model, positions, contact.other.hex);
    bool found = hold(model, before, vertex, position, last, within_hex, held);
    if (!found) {
      if (boxes.empty())
        for (const HexTree& tree : step.geometry->touchable.trees) boxes.push_back(boxes_at(tree, model, positions));
      found = hold_any(model, before, positions, vertex, position, hexes_at(step, boxes, vertex.hex, body, position),
                       held) ||
              hold(model, before, vertex, position, last, around_hex, held);
    }
    Contact next = contact;
    follow(model, positions, contact);
    if (!found) continue;
    take(step, positions, held, measure(model, held, leaving_of(step, vertex.hex, held.other.hex)), next);
    move_on(model, positions, next, contact);
  }
}

void make_room_for_planes(const Model& model, std::vector<Contact>& contacts) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> of_vertices;  // against bodies
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (contacts[i].between_bodies())
      of_vertices[{contacts[i].point.index, bodies_of(model, contacts[i]).second}].push_back(i);
  std::vector<char> goes(contacts.size(), 0);
  for (const auto& [vertex, planes] : of_vertices) {
    std::size_t stay = planes.size();
    for (auto plane = planes.begin(); plane != planes.end(); ++plane) {
      const auto same = std::find_if(planes.begin(), plane, [&](std::size_t known) {
        return contacts[known].normal == contacts[*plane].normal && contacts[known].gap == contacts[*plane].gap;
      });
      if (same == plane) continue;
      contacts[*same].force += contacts[*plane].force;
      goes[*plane] = 1;
      --stay;
    }
    if (stay < most_planes) continue;
    const std::size_t farthest = *std::max_element(
        planes.begin(), planes.end(), [&](std::size_t a, std::size_t b) { return contacts[a].gap < contacts[b].gap; });
    if (contacts[farthest].force.isZero(0) && contacts[farthest].gap > tolerance_depth(model, contacts[farthest]))
      goes[farthest] = 1;
  }
  std::size_t count = 0;  // that stay
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (!goes[i]) contacts[count++] = contacts[i];
  contacts.resize(count);
}

void keep_at_vertex(const Model& model, const Points& positions, Contact& contact) {
  MaterialPoint material;
  if (!find_material(hex_maps(model, positions, contact.other.hex),
                     embedded_position(model, positions, contact.support), around_hex, material))
    return;
  contact.other.weights = material.weights;
  contact.position = contact_position(model, positions, contact);
}

}  // namespace umax
