#include "core/contact/meeting.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;  // [-] of distances
constexpr int worth_a_look = 4;    // vertices of a cluster: fewer are looked at one by one

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
double least_distance(const Model::BodyRange& body, const HexBounds& bounds, const Vector3d& position, double radius) {
  if (!std::isfinite(bounds.rest_error)) return -infinity;
  const Vector3d rest = bounds.rest_centre + bounds.rest_from_world * (position - bounds.centre);
  return distance_bounds(surface_of(body), body.rest_pose.local(rest)).low - bounds.rest_error -
         bounds.rest_stretch * radius;
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

// of the point from the box, squared [m^2]
double squared_distance(const Eigen::AlignedBox3d& box, const Vector3d& point) {
  return (box.min() - point).cwiseMax(point - box.max()).cwiseMax(0.0).squaredNorm();
}

// How far [m] points within a radius of this one are at least from touching in the hex; 0 or less: they may.
double clear_of(const Meeting& meeting, const OtherHex& other, const Vector3d& position, double radius) {
  const double outside = distance_from(*other.bounds, position) - radius;
  if (outside > 0) return outside;
  const double distance = least_distance(meeting.body, *other.bounds, position, radius);
  return distance > other.largest_move ? distance : 0;
}

// The same of those of the hexes in which they do not. Calls may_touch(other) for all others, of which its box tells most.
template <class MayTouch>
double clear_of_all(const Meeting& meeting, const std::vector<OtherHex>& others, const Vector3d& position,
                    double radius, const MayTouch& may_touch) {
  double least = infinity, least_squared = infinity;
  for (const OtherHex& other : others) {
    const double squared = squared_distance(other.box, position);
    if (squared > radius * radius) {
      least_squared = std::min(least_squared, squared);
      continue;
    }
    const double clear = clear_of(meeting, other, position, radius);
    if (clear > 0)
      least = std::min(least, clear);
    else
      may_touch(other);
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

// how many vertices of the cluster may touch by what is known
int num_near(const Meeting& meeting, const VertexCluster& cluster, int first) {
  const auto begin = meeting.clearance.until.begin() + first;
  return int(
      std::count_if(begin, begin + cluster.count, [&](double value) { return !(value > meeting.clearance.way); }));
}

// What bounds tell of the vertices of a cluster, the first of which is `first`, against these hexes: of all together, and
// where these are near, of each. Calls tell(until, on which way the vertex may touch at the earliest).
template <class Tell>
void look_at_cluster(const Meeting& meeting, const std::vector<OtherHex>& others, const VertexCluster& cluster,
                     int first, const Tell& tell) {
  const ClusterSphere sphere = sphere_around(cluster, meeting.nodes, meeting.half_edges);
  std::vector<OtherHex> near;
  const double least = clear_of_all(meeting, others, sphere.centre, sphere.radius,
                                    [&](const OtherHex& other) { near.push_back(other); });
  for (int k = first; k < first + cluster.count; ++k) {
    double of_vertex = least;
    if (!near.empty()) {
      const Vector3d position = meeting.nodes.transpose() * vertex_support(meeting, k).weights;
      bool may_touch = false;
      const double clear = clear_of_all(meeting, near, position, 0, [&](const OtherHex&) { may_touch = true; });
      of_vertex = may_touch ? 0 : std::min(least, clear);
    }
    tell(meeting.clearance.until[std::size_t(k)], clear_until(meeting, of_vertex));
  }
}

// The same of those clusters of the hex of which at least so many vertices may touch by what is known.
void look_at_clusters(const Meeting& meeting, int least_near) {
  for_each_cluster(meeting, [&](const VertexCluster& cluster, int first) {
    if (num_near(meeting, cluster, first) >= least_near)
      look_at_cluster(meeting, meeting.others, cluster, first,
                      [](double& known, double until) { known = std::max(known, until); });
  });
}

// Of hexes that are new to the encounter; vertices that may touch anyway learn nothing from them.
void look_at_unseen(const Meeting& meeting) {
  std::vector<int>& unseen = meeting.clearance.unseen;
  if (unseen.empty()) return;
  std::vector<OtherHex> others;
  for (const OtherHex& other : meeting.others)
    if (std::binary_search(unseen.begin(), unseen.end(), other.hex)) others.push_back(other);
  for_each_cluster(meeting, [&](const VertexCluster& cluster, int first) {
    if (num_near(meeting, cluster, first) < cluster.count)
      look_at_cluster(meeting, others, cluster, first,
                      [](double& known, double until) { known = std::min(known, until); });
  });
  unseen.clear();
}

void find_near(Meeting& meeting) {
  const std::vector<double>& until = meeting.clearance.until;
  double& least = meeting.clearance.least;
  least = infinity;
  for (int k = 0; k < int(until.size()); ++k) {
    least = std::min(least, until[std::size_t(k)]);
    if (!(until[std::size_t(k)] > meeting.clearance.way)) meeting.near.push_back(k);
  }
  std::sort(meeting.near.begin(), meeting.near.end(),
            [&](int a, int b) { return std::pair(until[std::size_t(a)], a) < std::pair(until[std::size_t(b)], b); });
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
                  {},
                  {},
                  search.clearances.of_encounters[i]};
  if (meeting.clearance.least > meeting.clearance.way && meeting.clearance.unseen.empty()) return meeting;
  meeting.nodes = hex_nodes(model, positions, encounter.hex);
  meeting.half_edges = longest_half_edges(meeting.nodes);
  const Eigen::AlignedBox3d moves = moves_of(model, before, positions, encounter.hex);
  for (const int other : encounter.others) {
    const HexBounds& bounds = search.bounds[std::size_t(other)];
    const double against = largest_motion(moves, moves_of(model, before, positions, other));
    meeting.others.push_back({other, bounds.box, &bounds, against > 0 ? bounds.largest_inverse * against : 0});
  }
  std::vector<double>& until = meeting.clearance.until;
  if (until.empty()) until.assign(num_vertices(meeting.clusters, encounter.hex), -infinity);
  look_at_unseen(meeting);
  look_at_clusters(meeting, worth_a_look);
  find_near(meeting);
  return meeting;
}

bool find_held(const Meeting& meeting, int k, HeldVertex& held) {
  const Support vertex = vertex_support(meeting, k);
  const Vector3d position = meeting.nodes.transpose() * vertex.weights;
  bool is_held = false;
  double least_held = infinity;  // of hexes that may hold it, or do
  const double least = clear_of_all(meeting, meeting.others, position, 0, [&](const OtherHex& other) {
    if (is_held) return;
    const bool is_inside = hold(meeting.model, meeting.apart, vertex, position, other.bounds->maps, within_hex, held);
    is_held = is_inside && !is_clear(surface_of(meeting.body), held);
    least_held = std::min(least_held, is_inside ? held.bounds.low : distance_beyond(*other.bounds, position));
  });
  if (!is_held) meeting.clearance.until[std::size_t(k)] = clear_until(meeting, std::min(least, least_held));
  return is_held;
}

void remember(const Meeting& meeting, int k, const HeldVertex& held, const Touch& touch) {
  double least = std::min(touch.gap, touch.clear);
  if (least > 0) {  // a hex that is folded over the one that holds the vertex may hold it, too
    const Vector3d position = meeting.nodes.transpose() * held.vertex.weights;
    for (const OtherHex& other : meeting.others)
      if (squared_distance(other.box, position) < least * least &&
          !share_node(meeting.model, other.hex, held.other.hex))
        least = std::min(least, clear_of(meeting, other, position, 0));
  }
  meeting.clearance.until[std::size_t(k)] = clear_until(meeting, least);
}

}  // namespace umax
