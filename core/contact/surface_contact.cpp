#include "core/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/contact/contact_detection.h"
#include "core/contact/contact_support.h"
#include "core/contact/held_vertex.h"
#include "core/contact/material_point.h"

namespace umax {
namespace {

constexpr double one_way = 0.3;      // [-] of the depths of vertices in a body, that their ways out have in common
constexpr double same_plane = 0.99;  // [-] cosine between normals
constexpr double least_turn = 1e-3;  // [-] of a normal between iterates, that counts
constexpr double kept_share = 0.5;   // [penetration tolerances] that it lets a vertex be inside

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

// Bound of the distance [m] from the touched surface of points within a radius of this one, if the hex holds them.
double least_distance(const Model::BodyRange& body, const OtherHex& other, const Vector3d& position, double radius) {
  const HexBounds& bounds = other.bounds;
  if (!std::isfinite(bounds.rest_error)) return -std::numeric_limits<double>::infinity();
  const Vector3d rest = bounds.rest_centre + bounds.rest_from_world * (position - bounds.centre);
  return distance_bounds(*body.rest_surface, body.rest_pose.local(rest)).low - bounds.rest_error -
         (radius > 0 ? bounds.rest_from_world.norm() * radius : 0);
}

// can the vertex be inside the surface, or have come through it, if the hex holds it?
bool may_touch_in(const Model::BodyRange& body, const OtherHex& other, const Vector3d& position) {
  return may_hold(other.bounds, position) && least_distance(body, other, position, 0) <= other.largest_move;
}

// What a search at some positions goes through.
struct Search {
  std::vector<Encounter> encounters;
  std::vector<HexBounds> bounds;  // #E
};

// A hex whose vertices may be in hexes of a body, at the positions.
struct Meeting {
  const Model& model;
  const VertexClusters& clusters;
  const Points &apart, &positions;
  const Model::BodyRange& body;
  int hex = 0;
  Matrix8x3d nodes;
  const WayOut* way = nullptr;
  std::vector<OtherHex> others;
};
Meeting meet(const ContactStep& step, const Points& apart, const Points& positions, const Search& search,
             const Encounter& encounter) {
  const Model& model = *step.model;
  Meeting meeting{model,
                  step.geometry->clusters,
                  apart,
                  positions,
                  model.bodies[encounter.body],
                  encounter.hex,
                  hex_nodes(model, positions, encounter.hex),
                  way_between(step, encounter.hex, encounter.others.front()),
                  {}};
  for (const int other : encounter.others)
    if (may_meet(search.bounds[other], meeting.nodes, 0))
      meeting.others.push_back(see(model, apart, positions, encounter.hex, other, search.bounds[other]));
  return meeting;
}

// A cluster of which vertices may touch the body, and the least gap [m] that one may have there.
struct NearCluster {
  int cluster = 0;
  double least = 0;
};

// the clusters that may touch, those of the least gaps first
std::vector<NearCluster> near_clusters(const Meeting& meeting) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<NearCluster> near;
  if (meeting.others.empty()) return near;
  for (int c = meeting.clusters.hex_starts[meeting.hex]; c < meeting.clusters.hex_starts[meeting.hex + 1]; ++c) {
    const ClusterSphere sphere = sphere_around(meeting.clusters.all[c], meeting.nodes);
    double least = infinity;
    for (const OtherHex& other : meeting.others) {
      if (!may_hold(other.bounds, sphere.centre, sphere.radius)) continue;
      const double distance = least_distance(meeting.body, other, sphere.centre, sphere.radius);
      if (distance > other.largest_move) continue;
      double deepest = std::max(-distance, other.largest_move);
      if (meeting.way) deepest = infinity;  // not by what is nearest
      least = std::min(least, std::isfinite(deepest) ? -deepest * other.bounds.largest_stretch : -infinity);
    }
    if (least < infinity) near.push_back({c, least});
  }
  std::sort(near.begin(), near.end(), [](const NearCluster& a, const NearCluster& b) {
    return std::pair(a.least, a.cluster) < std::pair(b.least, b.cluster);
  });
  return near;
}

// Calls visit(vertex, held) for each vertex of the cluster that is in one of the other hexes, and inside the surface there,
// or may have come through it.
template <class Visit>
void visit_held(const Meeting& meeting, const NearCluster& near, const Visit& visit) {
  const VertexCluster& cluster = meeting.clusters.all[near.cluster];
  for (int k = cluster.first; k < cluster.first + cluster.count; ++k) {
    const int point = meeting.clusters.points[k];
    const Support vertex{meeting.hex, meeting.model.surface.weights.row(point).transpose()};
    const Vector3d position = meeting.nodes.transpose() * vertex.weights;
    HeldVertex held;
    for (const OtherHex& other : meeting.others)
      if (may_touch_in(meeting.body, other, position) &&
          hold(meeting.model, meeting.apart, meeting.positions, vertex, position, other.hex, within_hex, held) &&
          !is_clear(*meeting.body.rest_surface, held)) {
        visit(point, held);
        break;
      }
  }
}

void take(const ContactStep& step, const Points& positions, const HeldVertex& held, const Touch& touch,
          Contact& contact) {
  const AllowedDepth allowed = allowance(step, held);
  contact.other = held.other;
  contact.normal = touch.normal;
  contact.gap = touch.gap + allowed.deep + allowed.shallow;
  // what is pushed out of an overlap slides: friction would hold a body by its sides
  contact.friction = allowed.deep > 0 ? 0
                                      : friction_between(*step.model, step.model->hex_body[contact.support.hex],
                                                         step.model->hex_body[contact.other.hex]);
  contact.position = contact_position(*step.model, positions, contact);
}

// The deepest vertex of those with gaps below `below`; clusters and vertices of which bounds say that they are not as
// deep get no closer look. deep(held): [m] that is allowed anyway.
struct DeepestVertex {
  int point = -1;
  double gap = 0;  // [m] beyond what is allowed
  HeldVertex held;
  Touch touch;
};
template <class Deep>
DeepestVertex find_deepest(const Meeting& meeting, double below, const Deep& deep) {
  DeepestVertex deepest;
  deepest.gap = below;
  const double tie = tied_depth(meeting.model, meeting.hex);
  for (const NearCluster& near : near_clusters(meeting)) {
    if (near.least > deepest.gap + tie) break;
    visit_held(meeting, near, [&](int point, const HeldVertex& held) {
      const double most = deepest.gap + tie;
      if (!meeting.way && least_gap(held) > most) return;
      const Touch touch = measure(meeting.model, held, meeting.way);
      if (touch.gap > most) return;
      const double gap = touch.gap + deep(held);
      const bool is_tied = deepest.point >= 0 && std::abs(gap - deepest.gap) <= tie;
      if (is_tied ? point < deepest.point : gap < deepest.gap) deepest = {point, gap, held, touch};
    });
  }
  return deepest;
}

// the vertex of a hex that is deepest in a body, of those deeper than `share` of what is tolerated
std::optional<Contact> deepest_vertex(const ContactStep& step, const LastApart& apart, const Points& positions,
                                      const Search& search, const Encounter& encounter, double share) {
  const Model& model = *step.model;
  const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
  const DeepestVertex deepest =
      find_deepest(meet(step, apart.of(encounter.hex, encounter.body), positions, search, encounter),
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
    take(step, positions, held, measure(model, held, way_between(step, vertex.hex, held.other.hex)), next);
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
    const Meeting meeting = meet(step, positions, positions, search, encounter);
    for (const NearCluster& near : near_clusters(meeting))
      visit_held(meeting, near, [&](int, const HeldVertex& held) {
        const double gap = measure(model, held, nullptr).gap;
        if (gap >= 0) return;
        ++overlap.vertices;
        overlap.depth = std::max(overlap.depth, -gap);
      });
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

bool are_deep(const ContactStep& step, const std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    HeldVertex held;
    const Vector3d position = embedded_position(model, step.positions_t0, contact.support);
    return contact.between_bodies() &&
           hold(model, step.positions_t0, step.positions_t0, contact.support, position, contact.other.hex, around_hex,
                held) &&
           measure(model, held, nullptr).gap < -nearly_outside * tolerance_depth(model, contact);
  });
}

std::map<std::pair<int, int>, WayOut> find_ways_out(const ContactStep& step) {
  const Model& model = *step.model;
  const ContactStep rest = at_rest(model, *step.geometry, step.positions_t0);
  const Search search = search_at(rest, step.positions_t0);
  struct Sum {
    Vector3d ways = Vector3d::Zero();  // [m] depth by normal
    double depths = 0, deepest = 0;    // [m]
  };
  std::vector<Sum> of_encounters(search.encounters.size());
  for_each_encounter(search.encounters, [&](Eigen::Index i, const Encounter& encounter) {
    if (model.hex_body[encounter.hex] == encounter.body) return;
    Sum& sum = of_encounters[std::size_t(i)];
    const Meeting meeting = meet(rest, step.positions_t0, step.positions_t0, search, encounter);
    const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
    for (const NearCluster& near : near_clusters(meeting))
      visit_held(meeting, near, [&](int, const HeldVertex& held) {
        const Touch touch = measure(model, held, nullptr);
        if (touch.gap >= -nearly_outside * tolerance) return;
        sum.ways -= touch.gap * touch.normal;
        sum.depths -= touch.gap;
        sum.deepest = std::max(sum.deepest, -touch.gap);
      });
  });
  std::map<std::pair<int, int>, Sum> sums;  // the smaller body's way out of the other
  for (std::size_t i = 0; i < of_encounters.size(); ++i) {
    const int body = model.hex_body[search.encounters[i].hex], other = search.encounters[i].body;
    Sum& sum = sums[std::minmax(body, other)];
    sum.ways += (body < other ? 1 : -1) * of_encounters[i].ways;
    sum.depths += of_encounters[i].depths;
    sum.deepest = std::max(sum.deepest, of_encounters[i].deepest);
  }
  std::map<std::pair<int, int>, WayOut> ways;
  for (const auto& [bodies, sum] : sums) {
    if (!(sum.ways.norm() > one_way * sum.depths)) continue;
    ways[bodies] = {sum.ways.normalized(), sum.deepest};
    ways[{bodies.second, bodies.first}] = {-sum.ways.normalized(), sum.deepest};
  }
  return ways;
}

double max_surface_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return 0;
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  VectorXd depths = VectorXd::Zero(Eigen::Index(search.encounters.size()));
  for_each_encounter(search.encounters, [&](Eigen::Index i, const Encounter& encounter) {
    const DeepestVertex deepest =
        find_deepest(meet(step, positions, positions, search, encounter), 0, [](const HeldVertex&) { return 0.0; });
    depths[i] = -deepest.gap;
  });
  return depths.size() ? depths.maxCoeff() : 0;
}

}  // namespace umax
