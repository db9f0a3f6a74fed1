#include "core/contact/meeting.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-9;  // [-] of distances

// how far nodes of the two hexes move against each other between two sets of positions [m]
double largest_motion(const Model& model, const Points& from, const Points& to, int a, int b) {
  const auto moves = [&](int hex) -> Matrix8x3d { return hex_nodes(model, to, hex) - hex_nodes(model, from, hex); };
  const Matrix8x3d moves_a = moves(a), moves_b = moves(b);
  double largest = 0;
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n) largest = std::max(largest, (moves_a.row(m) - moves_b.row(n)).squaredNorm());
  return std::sqrt(largest);
}

// Bound of the distance [m] from the touched surface of points within a radius of this one, if the hex holds them.
double least_distance(const Model::BodyRange& body, const HexBounds& bounds, const Vector3d& position, double radius) {
  if (!std::isfinite(bounds.rest_error)) return -infinity;
  const Vector3d rest = bounds.rest_centre + bounds.rest_from_world * (position - bounds.centre);
  return distance_bounds(*body.rest_surface, body.rest_pose.local(rest)).low - bounds.rest_error -
         (radius > 0 ? bounds.rest_from_world.norm() * radius : 0);
}

const int* first_vertex(const VertexClusters& clusters, int hex) {
  return clusters.points.data() + clusters.all[std::size_t(clusters.hex_starts[hex])].first;
}

Support vertex_support(const Meeting& meeting, int k) {
  return {meeting.hex, meeting.model.surface.weights.row(meeting.vertices[k]).transpose()};
}

// How far [m] points within a radius of this one are at least from touching in the hex; 0 or less: they may.
double clear_of(const Meeting& meeting, const OtherHex& other, const Vector3d& position, double radius) {
  const double outside = distance_from(*other.bounds, position) - radius;
  if (outside > 0) return outside;
  const double distance = least_distance(meeting.body, *other.bounds, position, radius);
  return distance > other.largest_move ? distance : 0;
}

// on which way of the hexes a vertex that is so far from touching [m] may touch at the earliest
double clear_until(const Meeting& meeting, double clear) {
  return meeting.clearance.way + (1 - rounding) * clear;
}

// What bounds tell of the vertices of a hex that is met for the first time: of clusters, and where these are near, of each.
void begin(const Meeting& meeting) {
  const int first_cluster = meeting.clusters.hex_starts[meeting.hex],
            end_cluster = meeting.clusters.hex_starts[meeting.hex + 1];
  std::vector<double>& until = meeting.clearance.until;
  std::vector<const OtherHex*> near;
  for (int c = first_cluster; c < end_cluster; ++c) {
    const VertexCluster& cluster = meeting.clusters.all[std::size_t(c)];
    const ClusterSphere sphere = sphere_around(cluster, meeting.nodes);
    double least = infinity;
    near.clear();
    for (const OtherHex& other : meeting.others) {
      const double clear = clear_of(meeting, other, sphere.centre, sphere.radius);
      if (clear > 0)
        least = std::min(least, clear);
      else
        near.push_back(&other);
    }
    for (int k = 0; k < cluster.count; ++k) {
      double of_vertex = least;
      if (!near.empty()) {
        const Vector3d position = meeting.nodes.transpose() * vertex_support(meeting, int(until.size())).weights;
        for (const OtherHex* other : near) of_vertex = std::min(of_vertex, clear_of(meeting, *other, position, 0));
      }
      until.push_back(clear_until(meeting, of_vertex));
    }
  }
}

void find_near(Meeting& meeting) {
  const std::vector<double>& until = meeting.clearance.until;
  for (int k = 0; k < int(until.size()); ++k)
    if (!(until[std::size_t(k)] > meeting.clearance.way)) meeting.near.push_back(k);
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

ContactStep at_rest(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  ContactStep step;
  step.model = &model;
  step.geometry = &geometry;
  step.positions_t0 = positions;
  step.recovery.assign(model.bodies.size(), 0);
  step.clearances = std::make_shared<Clearances>();
  step.clearances->encounters = find_encounters(model, geometry.touchable, geometry.hex_starts, positions, 0);
  return step;
}

Meeting meet(const Search& search, const LastApart& apart, std::size_t i) {
  const Model& model = *search.step.model;
  const Encounter& encounter = search.clearances.encounters.all[i];
  const Points &before = apart.of(encounter.hex, encounter.body), &positions = search.positions;
  Meeting meeting{model,
                  search.step.geometry->clusters,
                  before,
                  positions,
                  model.bodies[encounter.body],
                  encounter.hex,
                  first_vertex(search.step.geometry->clusters, encounter.hex),
                  {},
                  leaving_of(search.step, encounter.hex, encounter.others.front()),
                  {},
                  {},
                  search.clearances.of_encounters[i]};
  const bool is_known = !meeting.clearance.until.empty();
  if (is_known) find_near(meeting);
  if (is_known && meeting.near.empty()) return meeting;
  meeting.nodes = hex_nodes(model, positions, encounter.hex);
  for (const int other : encounter.others) {
    const HexBounds& bounds = search.bounds[std::size_t(other)];
    meeting.others.push_back(
        {other, &bounds, bounds.largest_inverse * largest_motion(model, before, positions, encounter.hex, other)});
  }
  if (!is_known) {
    begin(meeting);
    find_near(meeting);
  }
  return meeting;
}

bool find_held(const Meeting& meeting, int k, HeldVertex& held) {
  const Support vertex = vertex_support(meeting, k);
  const Vector3d position = meeting.nodes.transpose() * vertex.weights;
  double least = infinity;
  for (const OtherHex& other : meeting.others) {
    double clear = clear_of(meeting, other, position, 0);
    if (!(clear > 0) &&
        hold(meeting.model, meeting.apart, meeting.positions, vertex, position, other.hex, within_hex, held)) {
      if (!is_clear(*meeting.body.rest_surface, held)) return true;
      clear = held.bounds.low;
    }
    least = std::min(least, clear);
  }
  meeting.clearance.until[std::size_t(k)] = clear_until(meeting, least);
  return false;
}

void remember(const Meeting& meeting, int k, const HeldVertex& held, const Touch& touch) {
  double least = std::min(touch.gap, touch.clear);
  if (least > 0) {  // a hex that is folded over the one that holds the vertex may hold it, too
    const Vector3d position = meeting.nodes.transpose() * held.vertex.weights;
    for (const OtherHex& other : meeting.others)
      if (!share_node(meeting.model, other.hex, held.other.hex))
        least = std::min(least, clear_of(meeting, other, position, 0));
  }
  meeting.clearance.until[std::size_t(k)] = clear_until(meeting, least);
}

}  // namespace umax
