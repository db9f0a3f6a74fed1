#include "core/contact/meeting.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;  // [-] of distances

// a box around how the nodes of the hex move between two sets of positions [m]
Eigen::AlignedBox3d moves_of(const Model& model, const Points& from, const Points& to, int hex) {
  Eigen::AlignedBox3d moves;
  for (int n = 0; n < 8; ++n) {
    const int node = model.hexes(hex, n);
    moves.extend((to.row(node) - from.row(node)).transpose());
  }
  return moves;
}

// how far [m] what moves like this may move against each other
double largest_motion(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return (a.max() - b.min()).cwiseMax(b.max() - a.min()).norm();
}

// Bound of the distance [m] from the touched surface of points within a radius of this one, if the hex holds them.
double least_distance(const HexBounds& bounds, const Vector3d& position, double radius) {
  if (!std::isfinite(bounds.rest_error)) return -infinity;
  return least_distance(bounds.distances, position - bounds.centre) - bounds.rest_error - bounds.rest_stretch * radius;
}

const int* first_vertex(const VertexClusters& clusters, int hex) {
  return clusters.points.data() + clusters.all[std::size_t(clusters.hex_starts[hex])].first;
}

std::size_t num_vertices(const VertexClusters& clusters, int hex) {
  std::size_t count = 0;
  for (int c = clusters.hex_starts[hex]; c < clusters.hex_starts[hex + 1]; ++c)
    count += std::size_t(clusters.all[std::size_t(c)].count);
  return count;
}

Support vertex_support(const Meeting& meeting, int k) {
  return {meeting.hex, surface_weights(body_of(meeting.model, meeting.hex), meeting.vertices[k])};
}

// How far [m] points within a radius of this one are at least from touching in the hex; 0 or less: they may.
double clear_of(const OtherHex& other, const Vector3d& position, double radius) {
  const double outside = distance_from(*other.bounds, position) - radius;
  if (outside > 0) return outside;
  const double distance = least_distance(*other.bounds, position, radius);
  return distance > other.largest_move ? distance : 0;
}

// The same of those of the hexes (their numbers) in which they do not. Calls may_touch(number) for those where they may, of
// which its box tells most.
template <class MayTouch>
double clear_of_all(const Meeting& meeting, const std::vector<int>& numbers, const Vector3d& position, double radius,
                    const MayTouch& may_touch) {
  double least = infinity, least_squared = infinity;
  for (const int number : numbers) {
    const OtherHex& other = meeting.others[std::size_t(number)];
    const double squared = squared_distance(other.box, position);
    if (squared > radius * radius) {
      least_squared = std::min(least_squared, squared);
      continue;
    }
    const double clear = clear_of(other, position, radius);
    if (clear > 0)
      least = std::min(least, clear);
    else
      may_touch(number);
  }
  return std::min(least, std::sqrt(least_squared) - radius);
}

// on which way of the hexes a vertex that is so far from touching [m] may touch at the earliest
double clear_until(const Meeting& meeting, double clear) {
  return meeting.clearance.way + (1 - rounding) * clear;
}

// Calls visit(cluster, number of its first vertex among those of the hex).
template <class Visit>
void for_each_cluster(const Meeting& meeting, const Visit& visit) {
  int first = 0;
  for (int c = meeting.clusters.hex_starts[meeting.hex]; c < meeting.clusters.hex_starts[meeting.hex + 1]; ++c) {
    const VertexCluster& cluster = meeting.clusters.all[std::size_t(c)];
    visit(cluster, first);
    first += cluster.count;
  }
}

// by what is known
bool is_near(const Meeting& meeting, int k) {
  return !(meeting.clearance.until[std::size_t(k)] > meeting.clearance.way);
}

// Looks at the vertices of a cluster, the first of which is `first`, for which wanted(k): at all together against these
// hexes, and where some are near, at each against those. Calls tell(vertex) of each.
template <class Wanted, class Tell>
void look_at_cluster(Meeting& meeting, const std::vector<int>& others, const VertexCluster& cluster, int first,
                     const Wanted& wanted, const Tell& tell) {
  bool is_any_wanted = false;
  for (int k = first; k < first + cluster.count; ++k) is_any_wanted = is_any_wanted || wanted(k);
  if (!is_any_wanted) return;
  const ClusterSphere sphere = sphere_around(cluster, meeting.nodes, meeting.half_edges);
  std::vector<int>& near = meeting.near_cluster;
  near.clear();
  const double least =
      clear_of_all(meeting, others, sphere.centre, sphere.radius, [&](int number) { near.push_back(number); });
  if (!near.empty()) fetch_weights(body_of(meeting.model, meeting.hex), meeting.clusters, cluster);
  for (int k = first; k < first + cluster.count; ++k) {
    if (!wanted(k)) continue;
    NearVertex vertex;
    vertex.k = k;
    vertex.clear = least;
    vertex.first_other = vertex.end_other = int(meeting.near_others.size());
    if (!near.empty()) {
      vertex.position = meeting.nodes.transpose() * vertex_support(meeting, k).weights;
      const double clear =
          clear_of_all(meeting, near, vertex.position, 0, [&](int number) { meeting.near_others.push_back(number); });
      vertex.clear = std::min(least, clear);
      vertex.end_other = int(meeting.near_others.size());
    }
    tell(vertex);
  }
}

// Of hexes that are new to the encounter; vertices that may touch anyway learn nothing from them.
void look_at_unseen(Meeting& meeting) {
  std::vector<int>& unseen = meeting.clearance.unseen;
  if (unseen.empty()) return;
  std::vector<int> others;
  for (int number = 0; number < int(meeting.others.size()); ++number)
    if (std::binary_search(unseen.begin(), unseen.end(), meeting.others[std::size_t(number)].hex))
      others.push_back(number);
  for_each_cluster(meeting, [&](const VertexCluster& cluster, int first) {
    look_at_cluster(
        meeting, others, cluster, first, [&](int k) { return !is_near(meeting, k); },
        [&](const NearVertex& vertex) {
          double& until = meeting.clearance.until[std::size_t(vertex.k)];
          until = std::min(until, clear_until(meeting, vertex.first_other < vertex.end_other ? 0 : vertex.clear));
        });
  });
  meeting.near_others.clear();
  unseen.clear();
}

// the vertices that may touch, and of the others until when they cannot
void find_near(Meeting& meeting) {
  std::vector<double>& until = meeting.clearance.until;
  std::vector<int> all(meeting.others.size());
  std::iota(all.begin(), all.end(), 0);
  for_each_cluster(meeting, [&](const VertexCluster& cluster, int first) {
    look_at_cluster(
        meeting, all, cluster, first, [&](int k) { return is_near(meeting, k); },
        [&](const NearVertex& vertex) {
          if (vertex.first_other < vertex.end_other)
            meeting.near.push_back(vertex);
          else
            until[std::size_t(vertex.k)] = clear_until(meeting, vertex.clear);
        });
  });
  meeting.clearance.least = until.empty() ? infinity : *std::min_element(until.begin(), until.end());
  std::sort(meeting.near.begin(), meeting.near.end(), [&](const NearVertex& a, const NearVertex& b) {
    return std::pair(until[std::size_t(a.k)], a.k) < std::pair(until[std::size_t(b.k)], b.k);
  });
}

}  // namespace

Search search_at(const ContactStep& step, const Points& positions) {
  const Model& model = *step.model;
  const TouchableBodies& touchable = step.geometry->touchable;
  Search search{step, positions, *step.clearances, {}};
  complete(model, touchable, step.geometry->hex_starts, positions, encounter_margin, search.clearances);
  if (search.clearances.encounters.all.empty()) return search;
  search.bounds = bound_hexes(model, search.clearances.encounters.all, positions);
  advance(model, search.bounds, positions, search.clearances);
  return search;
}

ContactStep at_rest(const Model& model, const ContactGeometry& geometry, const Points& positions,
                    std::shared_ptr<Clearances> known) {
  ContactStep step;
  step.model = &model;
  step.geometry = &geometry;
  step.positions_t0 = positions;
  step.recovery.assign(model.bodies.size(), 0);
  step.clearances = known ? std::move(known) : std::make_shared<Clearances>();
  return step;
}

Meeting meet(const Search& search, const LastApart& apart, std::size_t i) {
  const Model& model = *search.step.model;
  const Encounter& encounter = search.clearances.encounters.all[i];
  const Points &before = apart.of(encounter.hex, encounter.body), &positions = search.positions;
  Meeting meeting{model,
                  search.step.geometry->clusters,
                  before,
                  model.bodies[encounter.body],
                  encounter.hex,
                  first_vertex(search.step.geometry->clusters, encounter.hex),
                  {},
                  {},
                  leaving_of(search.step, encounter.hex, encounter.others.front()),
                  search.clearances.of_encounters[i]};
  if (meeting.clearance.least > meeting.clearance.way && meeting.clearance.unseen.empty()) return meeting;
  meeting.nodes = hex_nodes(model, positions, encounter.hex);
  meeting.half_edges = longest_half_edges(meeting.nodes);
  const Eigen::AlignedBox3d moves = moves_of(model, before, positions, encounter.hex);
  meeting.others.reserve(encounter.others.size());
  for (const int other : encounter.others) {
    const HexBounds& bounds = search.bounds[std::size_t(other)];
    const double against = largest_motion(moves, moves_of(model, before, positions, other));
    meeting.others.push_back({other, bounds.box, &bounds, against > 0 ? bounds.largest_inverse * against : 0});
  }
  std::vector<double>& until = meeting.clearance.until;
  if (until.empty()) until.assign(num_vertices(meeting.clusters, encounter.hex), -infinity);
  look_at_unseen(meeting);
  find_near(meeting);
  return meeting;
}

bool find_held(const Meeting& meeting, const NearVertex& vertex, HeldVertex& held) {
  const Support support = vertex_support(meeting, vertex.k);
  const ScaledSurface surface = surface_of(meeting.body);
  double least = vertex.clear;
  for (int i = vertex.first_other; i < vertex.end_other; ++i) {
    const OtherHex& other = meeting.others[std::size_t(meeting.near_others[std::size_t(i)])];
    const HexMaps& maps = other.bounds->maps;
    const std::optional<Vector3d> s = find_local(maps, vertex.position);
    if (!s || !has_material(maps, *s, within_hex)) {
      least = std::min(least, s ? distance_beyond(*other.bounds, *s) : 0);
      continue;
    }
    const Vector3d X = meeting.body.rest_pose.local(rest_place(maps, *s));
    double outside = distance_bounds(surface, X).low;
    if (!(outside > other.largest_move)) {  // a closer look, at where it came from
      held = hold_at(meeting.model, meeting.apart, support, maps, *s);
      if (!is_clear(surface, held)) return true;
      outside = held.bounds.low;
    }
    least = std::min(least, outside);
  }
  meeting.clearance.until[std::size_t(vertex.k)] = clear_until(meeting, least);
  return false;
}

void remember(const Meeting& meeting, const NearVertex& vertex, const HeldVertex& held, const Touch& touch) {
  double least = std::min(touch.gap, touch.clear);
  if (least > 0) {  // a hex that is folded over the one that holds the vertex may hold it, too
    for (const OtherHex& other : meeting.others)
      if (squared_distance(other.box, vertex.position) < least * least &&
          !share_node(meeting.model, other.hex, held.other.hex))
        least = std::min(least, clear_of(other, vertex.position, 0));
  }
  meeting.clearance.until[std::size_t(vertex.k)] = clear_until(meeting, least);
}

}  // namespace umax
