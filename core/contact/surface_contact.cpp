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

constexpr double start_slack = 2;  // [penetration tolerances] that a vertex may be behind what it rests on
constexpr double same_side = 0.5;  // [-] cosine of normals of the side that a vertex came through
constexpr double anywhere = std::numeric_limits<double>::infinity();
constexpr double rounding = 1 + 1e-9;
constexpr double deep_enough = 50;  // [penetration tolerances] beyond which any vertex will do: the others join later

// A vertex seen from the material of the hex that it is in, at the end of the step and at its start.
struct HeldVertex {
  Support vertex, other;
  Matrix3d F_inverse;
  Vector3d X, X0;         // [m] in the frame of the rest surface; X0: where it came from
  DistanceBounds bounds;  // [m] of the distance at X
  double moved = 0;       // [m] from X0 to X
};

// What the vertex meets there.
struct Touch {
  Support other;
  double gap = 0, start_gap = 0;  // [m] at the end of the step, and at its start; where that was outside, any above 0
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

// The vertex as the hex sees it; false where the hex does not hold it.
bool hold(const ContactStep& step, const Points& positions, const Support& vertex, const Vector3d& position,
          int other_hex, double reach, HeldVertex& held) {
  const Model& model = *step.model;
  MaterialPoint material;
  if (!find_material(model, positions, other_hex, position, reach, material)) return false;
  const Model::BodyRange& body = body_of(model, other_hex);
  held.vertex = vertex;
  held.other = {other_hex, material.weights};
  held.F_inverse = material.F_inverse;
  const Vector3d came_from =
      embedded_position(model, step.positions_t0, vertex) - embedded_position(model, step.positions_t0, held.other);
  held.X = body.rest_pose.local(material.rest);
  held.X0 = body.rest_pose.local(material.rest + material.F_inverse * came_from);
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

Touch measure(const Model& model, const HeldVertex& held) {
  const Model::BodyRange& body = body_of(model, held.other.hex);
  const RestSurface& surface = *body.rest_surface;
  const auto stretch = [&](const Vector3d& normal) -> Vector3d {
    return held.F_inverse.transpose() * (body.rest_pose.rotation * normal);
  };
  Touch touch{held.other, 0, 1};
  const DistanceBounds start_bounds = distance_bounds(surface, held.X0);
  double started = start_bounds.low;
  if (!(started > 0)) {
    const SurfaceHit start = nearest_within(surface, held.X0, start_bounds);
    started = start.distance;
    touch.start_gap = start.distance / stretch(start.normal).norm();
  }
  const bool was_inside = started < -start_slack * tolerance_between(model, held.vertex.hex, held.other.hex);
  const SurfaceHit hit = was_inside ? nearest_within(surface, held.X, held.bounds)
                                    : hit_from_outside(surface, held);  // the nearest way out
  const Vector3d pulled = stretch(hit.normal);
  touch.gap = hit.distance / pulled.norm();
  touch.normal = pulled.normalized();
  return touch;
}

bool touch_hex(const ContactStep& step, const Points& positions, const Support& vertex, const Vector3d& position,
               int other_hex, double reach, Touch& touch) {
  HeldVertex held;
  if (!hold(step, positions, vertex, position, other_hex, reach, held)) return false;
  touch = measure(*step.model, held);
  return true;
}

// the first of the hexes that holds the vertex
bool touch_any(const ContactStep& step, const Points& positions, const Support& vertex, const Vector3d& position,
               const std::vector<int>& hexes, Touch& touch) {
  for (const int other : hexes)
    if (touch_hex(step, positions, vertex, position, other, within_hex, touch)) return true;
  return false;
}

// What is known of a hex before any vertex is looked at.
struct OtherHex {
  int hex = 0;
  HexBounds bounds;
  double largest_move = 0;  // [m] of the vertices' hex against this one in the step, at rest
};

// how far nodes of the two hexes move against each other in the step [m]
double largest_motion(const ContactStep& step, const Points& positions, int a, int b) {
  const auto moves = [&](int hex) -> Matrix8x3d {
    return hex_nodes(*step.model, positions, hex) - hex_nodes(*step.model, step.positions_t0, hex);
  };
  const Matrix8x3d moves_a = moves(a), moves_b = moves(b);
  double largest = 0;
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n) largest = std::max(largest, (moves_a.row(m) - moves_b.row(n)).squaredNorm());
  return std::sqrt(largest);
}

OtherHex see(const ContactStep& step, const Points& positions, int hex, int other, const HexBounds& bounds) {
  OtherHex seen{other, bounds};
  seen.largest_move = seen.bounds.largest_inverse * largest_motion(step, positions, hex, other);
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
std::vector<FoundVertex> find_held(const ContactStep& step, const Points& positions, const Search& search,
                                   const Encounter& encounter) {
  const Model& model = *step.model;
  const ContactGeometry& geometry = *step.geometry;
  const Model::BodyRange& body = model.bodies[encounter.body];
  const Matrix8x3d nodes = hex_nodes(model, positions, encounter.hex);
  std::vector<OtherHex> others;
  for (const int other : encounter.others)
    if (may_meet(search.bounds[other], nodes, 0))
      others.push_back(see(step, positions, encounter.hex, other, search.bounds[other]));
  std::vector<FoundVertex> found;
  if (others.empty()) return found;
  for (int k = geometry.hex_starts[encounter.hex]; k < geometry.hex_starts[encounter.hex + 1]; ++k) {
    const int point = geometry.hex_points[k];
    const Support vertex{encounter.hex, model.surface.weights.row(point).transpose()};
    const Vector3d position = nodes.transpose() * vertex.weights;
    HeldVertex held;
    for (const OtherHex& other : others)
      if (may_touch_in(body, other, position) && hold(step, positions, vertex, position, other.hex, within_hex, held) &&
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

// depth that a vertex may have at the end of the step, by how deep it was at its start
AllowedDepth allowance(const ContactStep& step, int hex, const Touch& touch) {
  const Model& model = *step.model;
  const double recovery = std::min(step.recovery[model.hex_body[hex]], step.recovery[model.hex_body[touch.other.hex]]);
  return allowed_depth(-touch.start_gap, tolerance_between(model, hex, touch.other.hex), recovery);
}

void take(const ContactStep& step, const Points& positions, const Touch& touch, Contact& contact) {
  const AllowedDepth allowed = allowance(step, contact.support.hex, touch);
  contact.other = touch.other;
  contact.normal = touch.normal;
  contact.gap = touch.gap + allowed.deep + allowed.shallow;
  contact.position = contact_position(*step.model, positions, contact);
}

// The deepest of the vertices, of those with gaps below `below`, by the rule deepest first as their bounds promise: the
// others need no closer look where these say that they are not as deep, nor any where one is deeper than `enough`.
// gap(touch): [m].
struct DeepestVertex {
  int point = -1;
  double gap = 0;  // [m]
  Touch touch;
};
template <class Gap>
DeepestVertex find_deepest(const Model& model, std::vector<FoundVertex> found, double below, double enough,
                           const Gap& gap) {
  DeepestVertex deepest{-1, below, {}};
  if (found.empty()) return deepest;
  const double tie = tied_depth(model, found.front().held.vertex.hex);
  std::sort(found.begin(), found.end(), [](const FoundVertex& a, const FoundVertex& b) {
    return std::pair(a.held.bounds.low, a.point) < std::pair(b.held.bounds.low, b.point);
  });
  for (const FoundVertex& vertex : found) {
    if (deepest.gap < enough) break;
    if (least_gap(vertex.held) > deepest.gap + tie) continue;
    const Touch touch = measure(model, vertex.held);
    const double its = gap(touch);
    const bool is_tied = deepest.point >= 0 && std::abs(its - deepest.gap) <= tie;
    if (is_tied ? vertex.point < deepest.point : its < deepest.gap) deepest = {vertex.point, its, touch};
  }
  return deepest;
}

// the vertex of a hex that is deepest in a body, of those deeper than `share` of what is tolerated
std::optional<Contact> deepest_vertex(const ContactStep& step, const Points& positions, const Search& search,
                                      const Encounter& encounter, double share) {
  const Model& model = *step.model;
  const int hex = encounter.hex;
  const double tolerance = tolerance_between(model, hex, encounter.others.front());
  const DeepestVertex deepest =
      find_deepest(model, find_held(step, positions, search, encounter), -share * tolerance, -deep_enough * tolerance,
                   [&](const Touch& touch) { return touch.gap + allowance(step, hex, touch).deep; });
  if (deepest.point < 0) return {};
  Contact contact = make_surface_contact(model, deepest.point, hex, deepest.touch.other.hex);
  take(step, positions, deepest.touch, contact);
  return contact;
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

std::vector<Contact> surface_candidates(const ContactStep& step, const Points& positions, double share) {
  if (!step.surfaces_touch || !step.geometry->touchable.any()) return {};
  const Search search = search_at(step, positions);
  const std::vector<Encounter>& encounters = search.encounters;
  std::vector<std::optional<Contact>> deepest(encounters.size());
  for_each_encounter(encounters, [&](Eigen::Index i, const Encounter& encounter) {
    deepest[std::size_t(i)] = deepest_vertex(step, positions, search, encounter, share);
  });
  std::vector<Contact> all;
  for (const std::optional<Contact>& contact : deepest)
    if (contact) all.push_back(*contact);
  return all;
}

void place_surface_contacts(const ContactStep& step, const Points& positions, std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  std::vector<std::vector<Eigen::AlignedBox3d>> boxes;  // made when the first vertex has left its hex
  for (Contact& contact : contacts) {
    if (!contact.between_bodies()) continue;
    const Vector3d position = embedded_position(model, positions, contact.support);
    Touch touch;
    bool found = touch_hex(step, positions, contact.support, position, contact.other.hex, within_hex, touch);
    if (!found) {
      if (boxes.empty())
        for (const HexTree& tree : step.geometry->touchable.trees) boxes.push_back(boxes_at(tree, model, positions));
      const int body = model.hex_body[contact.other.hex];
      const std::vector<int> hexes = hexes_at(step, boxes[body], contact.support.hex, body, position);
      found = touch_any(step, positions, contact.support, position, hexes, touch) ||
              touch_hex(step, positions, contact.support, position, contact.other.hex, around_hex, touch);
    }
    if (found)
      take(step, positions, touch, contact);
    else
      follow(model, positions, contact);
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
    for (const FoundVertex& vertex : find_held(step, positions, search, encounter)) {
      const Touch touch = measure(model, vertex.held);
      if (touch.gap >= 0) continue;
      ++overlap.vertices;
      overlap.depth = std::max(overlap.depth, -touch.gap);
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
    depths[i] =
        -find_deepest(model, find_held(step, positions, search, encounter), 0, -anywhere, [](const Touch& touch) {
           return touch.gap;
         }).gap;
  });
  return depths.size() ? depths.maxCoeff() : 0;
}

}  // namespace umax
