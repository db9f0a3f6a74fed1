#include "core/contact/surface_contact.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/contact/contact_detection.h"
#include "core/contact/contact_support.h"
#include "core/contact/material_point.h"

namespace umax {
namespace {

constexpr double same_side = 0.5;  // [-] cosine of normals of the side that a vertex came through
constexpr double anywhere = std::numeric_limits<double>::infinity();
constexpr double rounding = 1 + 1e-9;
constexpr double same_plane = 0.99;  // [-] cosine between normals
constexpr double least_turn = 1e-3;  // [-] of a normal between iterates, that counts
constexpr double kept_share = 0.5;   // [penetration tolerances] that it lets a vertex be inside

// A vertex seen from the material of the hex that it is in.
struct HeldVertex {
  Support vertex, other;
  Matrix3d F_inverse;
  Vector3d X, X0;         // [m] in the frame of the rest surface; X0: where it was last outside
  DistanceBounds bounds;  // [m] of the distance at X
  double moved = 0;       // [m] from X0 to X
};

// What the vertex meets there.
struct Touch {
  double gap = 0;  // [m]
  Vector3d normal = Vector3d::UnitY();
};

const Model::BodyRange& body_of(const Model& model, int hex) {
  return model.bodies[model.hex_body[hex]];
}

double tolerance_between(const Model& model, int hex, int other_hex) {
  return std::min(tolerance_depth(model, hex), tolerance_depth(model, other_hex));
}

SurfaceHit nearest_within(const RestSurface& surface, const Vector3d& point, const DistanceBounds& bounds) {
  return nearest_point(surface, point, std::max(std::abs(bounds.low), std::abs(bounds.high)));
}
SurfaceHit nearest_within(const RestSurface& surface, const Vector3d& point) {
  return nearest_within(surface, point, distance_bounds(surface, point));
}

// how the vertex is away from the other place at the positions, seen from the material there [m]
Vector3d away_at(const Model& model, const Points& positions, const HeldVertex& held) {
  return held.F_inverse *
         (embedded_position(model, positions, held.vertex) - embedded_position(model, positions, held.other));
}

// The vertex as the hex sees it; false where the hex does not hold it.
bool hold(const Model& model, const Points& apart, const Points& positions, const Support& vertex,
          const Vector3d& position, int other_hex, double reach, HeldVertex& held) {
  MaterialPoint material;
  if (!find_material(model, positions, other_hex, position, reach, material)) return false;
  const Model::BodyRange& body = body_of(model, other_hex);
  held.vertex = vertex;
  held.other = {other_hex, material.weights};
  held.F_inverse = material.F_inverse;
  held.X = body.rest_pose.local(material.rest);
  held.X0 = body.rest_pose.local(material.rest + away_at(model, apart, held));
  held.bounds = distance_bounds(*body.rest_surface, held.X);
  held.moved = (held.X - held.X0).norm();
  return true;
}

// is the vertex outside, and nowhere on its way from X0 near enough to the surface to have come through it?
bool is_clear(const RestSurface& surface, const HeldVertex& held) {
  if (!(held.bounds.low > 0)) return false;
  return held.bounds.low > held.moved || held.bounds.low + distance_bounds(surface, held.X0).low > held.moved;
}

// what a vertex outside at X0 meets at X
SurfaceHit hit_from_outside(const RestSurface& surface, const HeldVertex& held) {
  const SurfaceHit nearest = nearest_within(surface, held.X, held.bounds);
  if (nearest.triangle < 0) return nearest;
  const bool is_inside = nearest.distance < 0;
  if (!is_inside && nearest.distance > held.moved) return nearest;
  const int entered = first_entered(surface, held.X0, held.X);
  if (!is_inside && entered < 0) return nearest;
  const Vector3d side = entered < 0 ? nearest_within(surface, held.X0).normal
                                    : Vector3d(surface.triangle_normals.row(entered).transpose());
  const bool is_alike = surface.triangle_normals.row(nearest.triangle).dot(side.transpose()) >= same_side;
  const double reach = is_alike ? std::abs(nearest.distance) : entered < 0 ? anywhere : held.moved;
  const SurfaceHit alike = nearest_alike(surface, held.X, side, same_side, rounding * reach);
  return alike.triangle >= 0 ? alike : nearest;
}

// a normal of the touched body's rest surface, carried into the world; its length: what distances are divided by
Vector3d pushed_forward(const Model& model, const HeldVertex& held, const Vector3d& normal) {
  return held.F_inverse.transpose() * (body_of(model, held.other.hex).rest_pose.rotation * normal);
}

// was the vertex, when it was last outside, farther inside than rounding and tolerances explain?
bool was_inside(const Model& model, const RestSurface& surface, const HeldVertex& held) {
  const double slack = nearly_outside * tolerance_between(model, held.vertex.hex, held.other.hex);
  const DistanceBounds bounds = distance_bounds(surface, held.X0);
  return bounds.low < -slack && nearest_within(surface, held.X0, bounds).distance < -slack;
}

Touch measure(const Model& model, const HeldVertex& held) {
  const RestSurface& surface = *body_of(model, held.other.hex).rest_surface;
  const SurfaceHit hit = was_inside(model, surface, held) ? nearest_within(surface, held.X, held.bounds)
                                                          : hit_from_outside(surface, held);  // the nearest way out
  const Vector3d pushed = pushed_forward(model, held, hit.normal);
  return {hit.distance / pushed.norm(), pushed.normalized()};
}

// the depth that the vertex may have at the end of the step, by how deep it was at its start
AllowedDepth allowance(const ContactStep& step, const HeldVertex& held) {
  const Model& model = *step.model;
  const int hex = held.vertex.hex, other = held.other.hex;
  const Model::BodyRange& body = body_of(model, other);
  const Vector3d X_start = held.X + body.rest_pose.rotation.transpose() * away_at(model, step.positions_t0, held);
  const DistanceBounds bounds = distance_bounds(*body.rest_surface, X_start);
  if (bounds.low > 0) return {};
  const SurfaceHit start = nearest_within(*body.rest_surface, X_start, bounds);
  const double depth = -start.distance / pushed_forward(model, held, start.normal).norm();
  const double recovery = std::min(step.recovery[model.hex_body[hex]], step.recovery[model.hex_body[other]]);
  return allowed_depth(depth, tolerance_between(model, hex, other), recovery);
}

// the first of the hexes that holds the vertex
bool hold_any(const Model& model, const Points& apart, const Points& positions, const Support& vertex,
              const Vector3d& position, const std::vector<int>& hexes, HeldVertex& held) {
  return std::any_of(hexes.begin(), hexes.end(), [&](int other) {
    return hold(model, apart, positions, vertex, position, other, within_hex, held);
  });
}

// What is known of a hex before any vertex is looked at.
struct OtherHex {
  int hex = 0;
  HexBounds bounds;
  double largest_move = 0;  // [m] of the vertices' hex against this one since its vertices were outside, at rest
};

// how far nodes of the two hexes move against each other between two sets of positions [m]
double largest_motion(const Model& model, const Points& from, const Points& to, int a, int b) {
  const auto moves = [&](int hex) -> Matrix8x3d { return hex_nodes(model, to, hex) - hex_nodes(model, from, hex); };
  const Matrix8x3d moves_a = moves(a), moves_b = moves(b);
  double largest = 0;
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n) largest = std::max(largest, (moves_a.row(m) - moves_b.row(n)).squaredNorm());
  return std::sqrt(largest);
}

OtherHex see(const Model& model, const Points& apart, const Points& positions, int hex, int other,
             const HexBounds& bounds) {
  OtherHex seen{other, bounds};
  seen.largest_move = seen.bounds.largest_inverse * largest_motion(model, apart, positions, hex, other);
  return seen;
}

// can the vertex be inside the surface, or have come through it, if the hex holds it?
bool may_touch_in(const Model::BodyRange& body, const OtherHex& other, const Vector3d& position) {
  if (!may_hold(other.bounds, position)) return false;
  const double error = other.bounds.rest_error + other.largest_move;
  if (!std::isfinite(error)) return true;
  const Vector3d rest = other.bounds.rest_centre + other.bounds.rest_from_world * (position - other.bounds.centre);
  return distance_bounds(*body.rest_surface, body.rest_pose.local(rest)).low <= error;
}

// What a search at some positions goes through.
struct Search {
  std::vector<Encounter> encounters;
  std::vector<HexBounds> bounds;  // #E
};

// A vertex of the encounter's hex that is in one of the other hexes, and inside the surface there, or may have come
// through it.
struct FoundVertex {
  int point = 0;
  HeldVertex held;
};
std::vector<FoundVertex> find_held(const ContactStep& step, const Points& apart, const Points& positions,
                                   const Search& search, const Encounter& encounter) {
  const Model& model = *step.model;
  const ContactGeometry& geometry = *step.geometry;
  const Model::BodyRange& body = model.bodies[encounter.body];
  const Matrix8x3d nodes = hex_nodes(model, positions, encounter.hex);
  std::vector<OtherHex> others;
  for (const int other : encounter.others)
    if (may_meet(search.bounds[other], nodes, 0))
      others.push_back(see(model, apart, positions, encounter.hex, other, search.bounds[other]));
  std::vector<FoundVertex> found;
  if (others.empty()) return found;
  for (int k = geometry.hex_starts[encounter.hex]; k < geometry.hex_starts[encounter.hex + 1]; ++k) {
    const int point = geometry.hex_points[k];
    const Support vertex{encounter.hex, model.surface.weights.row(point).transpose()};
    const Vector3d position = nodes.transpose() * vertex.weights;
    HeldVertex held;
    for (const OtherHex& other : others)
      if (may_touch_in(body, other, position) &&
          hold(model, apart, positions, vertex, position, other.hex, within_hex, held) &&
          !is_clear(*body.rest_surface, held)) {
        found.push_back({point, held});
        break;
      }
  }
  return found;
}

// No gap of the vertex is below this [m]: what it came through is no farther than where it came from.
double least_gap(const HeldVertex& held) {
  return -std::max(-held.bounds.low, held.moved) * held.F_inverse.inverse().norm();
}

void take(const ContactStep& step, const Points& positions, const HeldVertex& held, const Touch& touch,
          Contact& contact) {
  const AllowedDepth allowed = allowance(step, held);
  contact.other = held.other;
  contact.normal = touch.normal;
  contact.gap = touch.gap + allowed.deep + allowed.shallow;
  contact.position = contact_position(*step.model, positions, contact);
}

// The deepest of the vertices, of those with gaps below `below`, by the rule deepest first as their bounds promise: the
// others need no closer look where these say that they are not as deep. deep(held): [m] that is allowed anyway.
struct DeepestVertex {
  int point = -1;
  double gap = 0;  // [m] beyond what is allowed
  HeldVertex held;
  Touch touch;
};
template <class Deep>
DeepestVertex find_deepest(const Model& model, std::vector<FoundVertex> found, double below, const Deep& deep) {
  DeepestVertex deepest;
  deepest.gap = below;
  if (found.empty()) return deepest;
  const double tie = tied_depth(model, found.front().held.vertex.hex);
  std::sort(found.begin(), found.end(), [](const FoundVertex& a, const FoundVertex& b) {
    return std::pair(a.held.bounds.low, a.point) < std::pair(b.held.bounds.low, b.point);
  });
  for (const FoundVertex& vertex : found) {
    const double most = deepest.gap + tie;
    if (least_gap(vertex.held) > most) continue;
    const Touch touch = measure(model, vertex.held);
    if (touch.gap > most) continue;
    const double gap = touch.gap + deep(vertex.held);
    const bool is_tied = deepest.point >= 0 && std::abs(gap - deepest.gap) <= tie;
    if (is_tied ? vertex.point < deepest.point : gap < deepest.gap) deepest = {vertex.point, gap, vertex.held, touch};
  }
  return deepest;
}

// the vertex of a hex that is deepest in a body, of those deeper than `share` of what is tolerated
std::optional<Contact> deepest_vertex(const ContactStep& step, const LastApart& apart, const Points& positions,
                                      const Search& search, const Encounter& encounter, double share) {
  const Model& model = *step.model;
  const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
  const DeepestVertex deepest =
      find_deepest(model, find_held(step, apart.of(encounter.hex, encounter.body), positions, search, encounter),
                   -share * tolerance, [&](const HeldVertex& held) { return allowance(step, held).deep; });
  if (deepest.point < 0) return {};
  Contact contact = make_surface_contact(model, deepest.point, encounter.hex, deepest.held.other.hex);
  take(step, positions, deepest.held, deepest.touch, contact);
  return contact;
}

bool undoes(const Vector3d& turn, const Vector3d& before) {
  return turn.norm() > least_turn && before.norm() > least_turn &&
         turn.dot(before) < -0.5 * turn.norm() * before.norm();
}

// The contact at its next place, or with its plane there.
void move_on(const Model& model, const Points& positions, const Contact& next, Contact& contact) {
  const bool kept_plane = keeps_plane(contact);
  const Vector3d turn = contact.normal.isZero(0) ? Vector3d(0, 0, 0) : Vector3d(next.normal - contact.normal);
  if (!kept_plane && undoes(turn, contact.turn)) ++contact.turns_back;
  contact.turn = turn;
  const bool is_away = next.gap > nearly_outside * tolerance_depth(model, next);
  if (keeps_plane(contact) && !is_away) {
    keep_at_vertex(model, positions, contact);
    if (next.normal.dot(contact.normal) > same_plane) contact.gap = next.gap;
    return;
  }
  const int turns_back = is_away ? 0 : contact.turns_back;
  contact = next;
  contact.turn = turn;
  contact.turns_back = turns_back;
}

// hexes of a body that may hold a vertex of the hex, ascending
std::vector<int> hexes_at(const ContactStep& step, const std::vector<Eigen::AlignedBox3d>& boxes, int hex, int body,
                          const Vector3d& position) {
  const Model& model = *step.model;
  std::vector<int> found;
  for_each_hex_in(step.geometry->touchable.trees[body], boxes, Eigen::AlignedBox3d(position), [&](int other) {
    if (body != model.hex_body[hex] || !share_node(model, hex, other)) found.push_back(other);
  });
  std::sort(found.begin(), found.end());
  return found;
}

// calls visit(i, encounter i) in parallel; their number
template <class Visit>
void for_each_encounter(const std::vector<Encounter>& encounters, const Visit& visit) {
  parallel_blocks(Eigen::Index(encounters.size()), 1, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) visit(i, encounters[std::size_t(i)]);
  });
}

// the step's encounters where they are complete at the positions, else new ones
Search search_at(const ContactStep& step, const Points& positions) {
  const Model& model = *step.model;
  const TouchableBodies& touchable = step.geometry->touchable;
  Search search{are_complete(model, step.encounters, positions, encounter_margin)
                    ? step.encounters.all
                    : find_encounters(model, touchable, step.geometry->hex_starts, positions, 0).all,
                {}};
  if (!search.encounters.empty()) search.bounds = bound_hexes(model, touchable, positions);
  return search;
}

// a step in which nothing moves
ContactStep at_rest(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  ContactStep step;
  step.model = &model;
  step.geometry = &geometry;
  step.positions_t0 = positions;
  step.recovery.assign(model.bodies.size(), 0);
  step.encounters = find_encounters(model, geometry.touchable, geometry.hex_starts, positions, 0);
  return step;
}

}  // namespace

std::vector<Contact> surface_candidates(const ContactStep& step, const LastApart& apart, const Points& positions,
                                        double share) {
  if (!step.surfaces_touch || !step.geometry->touchable.any()) return {};
  const Search search = search_at(step, positions);
  const std::vector<Encounter>& encounters = search.encounters;
  std::vector<std::optional<Contact>> deepest(encounters.size());
  for_each_encounter(encounters, [&](Eigen::Index i, const Encounter& encounter) {
    deepest[std::size_t(i)] = deepest_vertex(step, apart, positions, search, encounter, share);
  });
  std::vector<Contact> all;
  for (const std::optional<Contact>& contact : deepest)
    if (contact) all.push_back(*contact);
  return all;
}

bool bodies_meet(const ContactStep& step, const LastApart& apart, const Points& positions, double share) {
  const std::vector<Contact> contacts = surface_candidates(step, apart, positions, share);
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    const auto [first, second] = bodies_of(*step.model, contact);
    return first != second;
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
    bool found = hold(model, before, positions, vertex, position, contact.other.hex, within_hex, held);
    if (!found) {
      if (boxes.empty())
        for (const HexTree& tree : step.geometry->touchable.trees) boxes.push_back(boxes_at(tree, model, positions));
      found = hold_any(model, before, positions, vertex, position,
                       hexes_at(step, boxes[body], vertex.hex, body, position), held) ||
              hold(model, before, positions, vertex, position, contact.other.hex, around_hex, held);
    }
    Contact next = contact;
    follow(model, positions, contact);
    if (!found) continue;
    take(step, positions, held, measure(model, held), next);
    move_on(model, positions, next, contact);
  }
}

void keep_at_vertex(const Model& model, const Points& positions, Contact& contact) {
  MaterialPoint material;
  if (!find_material(model, positions, contact.other.hex, embedded_position(model, positions, contact.support),
                     around_hex, material))
    return;
  contact.other.weights = material.weights;
  contact.position = contact_position(model, positions, contact);
}

std::vector<Overlap> find_overlaps(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return {};
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  std::vector<Overlap> of_encounters(search.encounters.size());
  for_each_encounter(search.encounters, [&](Eigen::Index i, const Encounter& encounter) {
    Overlap& overlap = of_encounters[std::size_t(i)];
    overlap = {model.hex_body[encounter.hex], encounter.body};
    for (const FoundVertex& vertex : find_held(step, positions, positions, search, encounter)) {
      const double gap = measure(model, vertex.held).gap;
      if (gap >= 0) continue;
      ++overlap.vertices;
      overlap.depth = std::max(overlap.depth, -gap);
    }
  });
  std::map<std::pair<int, int>, Overlap> sums;
  for (const Overlap& overlap : of_encounters) {
    if (overlap.vertices == 0) continue;
    Overlap& sum = sums.try_emplace({overlap.a, overlap.b}, Overlap{overlap.a, overlap.b}).first->second;
    sum.vertices += overlap.vertices;
    sum.depth = std::max(sum.depth, overlap.depth);
  }
  std::vector<Overlap> overlaps;
  for (const auto& [bodies, sum] : sums) overlaps.push_back(sum);
  return overlaps;
}

double max_surface_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return 0;
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  VectorXd depths = VectorXd::Zero(Eigen::Index(search.encounters.size()));
  for_each_encounter(search.encounters, [&](Eigen::Index i, const Encounter& encounter) {
    const DeepestVertex deepest = find_deepest(model, find_held(step, positions, positions, search, encounter), 0,
                                               [](const HeldVertex&) { return 0.0; });
    depths[i] = -deepest.gap;
  });
  return depths.size() ? depths.maxCoeff() : 0;
}

}  // namespace umax
