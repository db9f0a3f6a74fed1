#include "core/contact/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/contact/clearances.h"
#include "core/contact/contact_detection.h"
#include "core/contact/contact_support.h"
#include "core/contact/edge_contact.h"
#include "core/contact/moving_obstacle.h"
#include "core/contact/obstacle_side.h"
#include "core/contact/surface_contact.h"

namespace umax {
namespace {

// no surface vertex may end a step deeper than this share of the cell size
constexpr double penetration_tolerance = 1e-3;
constexpr double came_outside = 10;  // times that: the depth at a step's start of a vertex that counts as outside
constexpr double kept_share = 0.5;   // of it, that a start's depth may keep: what a solution may add fits in the rest
constexpr Eigen::Index hexes_per_block = 64;

AllowedDepth allowance(const ContactStep& step, int obstacle, const Support& support) {
  const Vector3d before = embedded_position(*step.model, step.positions_t0, support);
  const ObstacleAt& start = step.obstacles_t0[obstacle];
  const double depth = -signed_distance(*start.shape, start.pose.local(before)).distance;
  return allowed_depth(depth, tolerance_depth(*step.model, support.hex),
                       step.recovery[step.model->hex_body[support.hex]]);
}

// how far a vertex has come against an obstacle's surface in the step [m], at most
double longest_way(const ContactStep& step, int obstacle, const Support& vertex, const Vector3d& position) {
  const Vector3d before = embedded_position(*step.model, step.positions_t0, vertex);
  const Pose &from = step.obstacles_t0[obstacle].pose, &to = step.obstacles_t1[obstacle].pose;
  return (to.local(position) - from.local(before)).norm() + step.deformations[obstacle];
}

// distance of a vertex at the end of the step from the side that it came by, and the outward direction, in the world
DistanceSample end_distance(const ContactStep& step, int obstacle, const Support& vertex, const Vector3d& position) {
  const Pose& pose = step.obstacles_t1[obstacle].pose;
  const ObstacleShape& shape = *step.obstacles_t1[obstacle].shape;
  if (!can_be_passed(shape)) {
    DistanceSample sample = signed_distance(shape, pose.local(position));
    sample.gradient = pose.rotation * sample.gradient;
    return sample;
  }
  const Vector3d before = embedded_position(*step.model, step.positions_t0, vertex);
  const Vector3d start = step.obstacles_t0[obstacle].pose.local(before), end = pose.local(position);
  DistanceSample sample;
  const bool is_dear = std::holds_alternative<TriangleShape>(shape);  // few vertices need a distance twice
  if (is_dear) sample = signed_distance(shape, end);
  if (!is_dear || sample.distance <= (end - start).norm() + step.deformations[obstacle])
    sample = distance_from_side(shape, carried_along(step, obstacle, start), end,
                                came_outside * tolerance_depth(*step.model, vertex.hex));
  sample.gradient = pose.rotation * sample.gradient;
  return sample;
}

// how far points of a hex may have come against an obstacle in the step [m], if it can be passed; sphere: around the hex now
double way_against(const ContactStep& step, int obstacle, int hex, const BoundingSphere& sphere) {
  if (!can_be_passed(step.model->obstacles[obstacle].shape)) return 0;
  const BoundingSphere before = bounding_sphere(hex_nodes(*step.model, step.positions_t0, hex));
  const Pose &from = step.obstacles_t0[obstacle].pose, &to = step.obstacles_t1[obstacle].pose;
  return (to.local(sphere.centre) - from.local(before.centre)).norm() + sphere.radius + before.radius +
         step.deformations[obstacle];
}

void place_vertex_contact(const ContactStep& step, const Points& positions, Contact& contact) {
  const Vector3d position = embedded_position(*step.model, positions, contact.support);
  const DistanceSample sample = end_distance(step, contact.obstacle, contact.support, position);
  const AllowedDepth allowed = allowance(step, contact.obstacle, contact.support);
  contact.gap = sample.distance + allowed.deep + allowed.shallow;
  contact.position = position;
  contact.normal = sample.gradient;
  contact.obstacle_motion = obstacle_point_motion(step, contact.obstacle, position);
}

void place(const ContactStep& step, const Points& positions, Contact& contact) {
  switch (contact.point.kind) {
    case ContactKind::vertex:
      return place_vertex_contact(step, positions, contact);
    case ContactKind::obstacle_edge:
      return place_edge_contact(step, positions, contact);
    case ContactKind::surface:
      return;  // by place_surface_contacts(), all at once
  }
}

// does the point touch the same obstacle in one of the first contacts?
bool in_set(const std::vector<Contact>& contacts, std::size_t count, const Contact& contact) {
  return std::any_of(contacts.begin(), contacts.begin() + std::ptrdiff_t(count), [&](const Contact& known) {
    return known.point == contact.point && known.obstacle == contact.obstacle;
  });
}

// of the first contacts, those of the same vertex with the same body
std::vector<Contact*> contacts_of(const Model& model, std::vector<Contact>& contacts, std::size_t count,
                                  const Contact& contact) {
  std::vector<Contact*> found;
  for (std::size_t i = 0; i < count; ++i)
    if (contacts[i].point == contact.point && contacts[i].between_bodies() &&
        bodies_of(model, contacts[i]).second == bodies_of(model, contact).second)
      found.push_back(&contacts[i]);
  return found;
}

// the deepest vertex of one hex against one obstacle, if any is below -threshold
bool deepest_vertex(const ContactStep& step, const Matrix8x3d& nodes, const BoundingSphere& sphere, int hex,
                    int obstacle, double threshold, ContactCandidate& deepest) {
  const Model& model = *step.model;
  const ContactGeometry& geometry = *step.geometry;
  const Model::BodyRange& body = body_of(model, hex);
  const ObstacleAt& end = step.obstacles_t1[obstacle];
  const double centre_distance = signed_distance(*end.shape, end.pose.local(sphere.centre)).distance;
  const double way = way_against(step, obstacle, hex, sphere);
  if (centre_distance > sphere.radius + way) return false;
  const bool is_triangles = std::holds_alternative<TriangleShape>(*end.shape);
  const Vector3d half_edges = longest_half_edges(nodes);
  deepest = {{ContactKind::vertex, -1}, obstacle, hex, -threshold};
  const double tie = tied_depth(model, hex);
  for (int c = geometry.clusters.hex_starts[hex]; c < geometry.clusters.hex_starts[hex + 1]; ++c) {
    const VertexCluster& cluster = geometry.clusters.all[c];
    const ClusterSphere around = sphere_around(cluster, nodes, half_edges);
    const double cluster_distance = signed_distance(*end.shape, end.pose.local(around.centre)).distance;
    if (cluster_distance > around.radius + way) continue;
    fetch_weights(body, geometry.clusters, cluster);
    for (int k = cluster.first; k < cluster.first + cluster.count; ++k) {
      const int point = geometry.clusters.points[k];
      const Support vertex{hex, surface_weights(body, point)};
      const Vector3d position = nodes.transpose() * vertex.weights;
      if (is_triangles &&
          cluster_distance - (position - around.centre).norm() > longest_way(step, obstacle, vertex, position))
        continue;
      double gap = end_distance(step, obstacle, vertex, position).distance;
      // of points that are tied, the one with the lowest index counts, whatever cluster it is in
      const auto counts = [&] {
        const bool is_tied = deepest.point.index >= 0 && gap < deepest.gap + tie && point < deepest.point.index;
        return is_tied || gap < deepest.gap - tie;
      };
      if (counts()) gap += allowance(step, obstacle, vertex).deep;
      if (counts()) deepest.point.index = point, deepest.gap = gap;
    }
  }
  return deepest.point.index >= 0;
}

std::vector<ContactCandidate> vertex_candidates(const ContactStep& step, const Points& positions, double share) {
  const Model& model = *step.model;
  const Eigen::Index num_blocks = (model.num_hexes() + hexes_per_block - 1) / hexes_per_block;
  std::vector<std::vector<ContactCandidate>> per_block(num_blocks);
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (int hex = int(begin); hex < int(end); ++hex) {
      if (step.geometry->hex_starts[hex] == step.geometry->hex_starts[hex + 1]) continue;
      const Matrix8x3d nodes = hex_nodes(model, positions, hex);
      const BoundingSphere sphere = bounding_sphere(nodes);
      if (!touches_obstacles(model, model.hex_body[hex])) continue;
      ContactCandidate candidate;
      for (int obstacle = 0; obstacle < int(model.obstacles.size()); ++obstacle)
        if (deepest_vertex(step, nodes, sphere, hex, obstacle, share * tolerance_depth(model, hex), candidate))
          per_block[begin / hexes_per_block].push_back(candidate);
    }
  });
  std::vector<ContactCandidate> all;
  for (const std::vector<ContactCandidate>& block : per_block) all.insert(all.end(), block.begin(), block.end());
  return all;
}

// half the speed of a fall through one cell, or a small share of the speed of sound where nothing falls: gentle at any
// scale
double recovery_speed(const Model::BodyRange& body, double gravity, double time) {
  const double sound = std::sqrt(body.material.young.at(time) / body.material.density.at(time));
  return std::max(0.5 * std::sqrt(gravity * body.cell_size), 0.01 * sound);
}

}  // namespace

AllowedDepth allowed_depth(double depth, double tolerance, double recovery) {
  if (depth <= tolerance) return {0, std::clamp(depth, 0.0, kept_share * tolerance)};
  return {std::max(0.0, depth - recovery), 0};
}

double tolerance_depth(const Model& model, int hex) {
  return penetration_tolerance * body_of(model, hex).cell_size;
}

Vector3d embedded_position(const Model& model, const Points& positions, const Support& support) {
  Vector3d position = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) position += support.weights[n] * positions.row(model.hexes(support.hex, n)).transpose();
  return position;
}

Contact make_contact(const Model& model, const ContactPoint& point, int obstacle, int hex) {
  Contact contact;
  contact.point = point;
  contact.obstacle = obstacle;
  contact.support.hex = hex;
  contact.support.weights = point.kind == ContactKind::obstacle_edge
                                ? Vector8d::Constant(0.125)
                                : Vector8d(surface_weights(body_of(model, hex), point.index));
  if (obstacle >= 0) contact.friction = std::max(body_of(model, hex).friction, model.obstacles[obstacle].friction);
  return contact;
}

Contact make_surface_contact(const Model& model, int vertex, int hex, int other_hex) {
  Contact contact = make_contact(model, {ContactKind::surface, vertex}, -1, hex);
  contact.other = {other_hex, Vector8d::Constant(0.125)};
  contact.normal.setZero();
  contact.friction = friction_between(model, model.hex_body[hex], model.hex_body[other_hex]);
  return contact;
}

ContactStep begin_contact_step(const Model& model, const ContactGeometry& geometry, const Points& positions_t0,
                               const Points& expected, double time_t0, double time_step, double gravity,
                               std::shared_ptr<Clearances> known) {
  ContactStep step;
  step.model = &model;
  step.geometry = &geometry;
  step.positions_t0 = positions_t0;
  for (const Obstacle& obstacle : model.obstacles) {
    step.obstacles_t0.push_back(obstacle_at(obstacle, time_t0));
    step.obstacles_t1.push_back(obstacle_at(obstacle, time_t0 + time_step));
    step.deformations.push_back(largest_deformation(step.obstacles_t0.back(), step.obstacles_t1.back()));
  }
  for (const Model::BodyRange& body : model.bodies)
    step.recovery.push_back(time_step * recovery_speed(body, gravity, time_t0));
  step.clearances = known ? std::move(known) : std::make_shared<Clearances>();
  if (!geometry.touchable.any()) return step;
  for (const HexTree& tree : geometry.touchable.trees) step.boxes_t0.push_back(boxes_at(tree, model, positions_t0));
  complete(model, geometry.touchable, geometry.hex_starts, expected, encounter_margin, *step.clearances);
  return step;
}

void update_contacts(const ContactStep& step, const LastApart& apart, const Points& positions,
                     std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) place(step, positions, contact);
  place_surface_contacts(step, apart, positions, contacts);
}

void follow_contacts(const ContactStep& step, const Points& positions, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) {
    follow(*step.model, positions, contact);
    if (contact.between_bodies()) keep_at_vertex(*step.model, positions, contact);
  }
}

void follow(const Model& model, const Points& positions, Contact& contact) {
  const Vector3d position = contact_position(model, positions, contact);
  contact.gap += contact.normal.dot(position - contact.position);
  contact.position = position;
}

int add_obstacle_contacts(const ContactStep& step, const Points& positions, double share,
                          std::vector<Contact>& contacts) {
  const std::size_t known = contacts.size();
  std::vector<ContactCandidate> candidates = vertex_candidates(step, positions, share);
  const std::vector<ContactCandidate> edges = edge_candidates(step, positions, share);
  candidates.insert(candidates.end(), edges.begin(), edges.end());
  for (const ContactCandidate& candidate : candidates) {
    Contact contact = make_contact(*step.model, candidate.point, candidate.obstacle, candidate.hex);
    if (in_set(contacts, known, contact)) continue;
    place(step, positions, contact);
    contacts.push_back(contact);
  }
  return int(contacts.size() - known);
}

int add_surface_contacts(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                         std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  const std::size_t known = contacts.size();
  for (Contact candidate : surface_candidates(step, apart, positions, share)) {
    const std::vector<Contact*> planes = contacts_of(model, contacts, known, candidate);
    if (!std::all_of(planes.begin(), planes.end(), [](const Contact* plane) { return keeps_plane(*plane); })) continue;
    if (std::any_of(planes.begin(), planes.end(), [&](const Contact* plane) { return plane->gap <= candidate.gap; }))
      continue;
    if (planes.size() == most_planes) continue;
    // such a plane takes a kept one's place when the vertex is there (place_surface_contacts())
    if (std::any_of(planes.begin(), planes.end(),
                    [&](const Contact* plane) { return leave_no_room(*plane, candidate); }))
      continue;
    if (!planes.empty()) candidate.turns_back = planes.front()->turns_back;
    contacts.push_back(candidate);
  }
  return int(contacts.size() - known);
}

int add_contacts(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                 std::vector<Contact>& contacts) {
  const int added = add_obstacle_contacts(step, positions, share, contacts);
  return added + add_surface_contacts(step, apart, positions, share, contacts);
}

std::vector<int> hexes_near_obstacles(const ContactStep& step, const Points& positions, double margin) {
  const Model& model = *step.model;
  std::vector<int> near;
  for (int hex = 0; hex < int(model.num_hexes()); ++hex) {
    if (step.geometry->hex_starts[hex] == step.geometry->hex_starts[hex + 1]) continue;
    if (!touches_obstacles(model, model.hex_body[hex])) continue;
    const BoundingSphere sphere = bounding_sphere(hex_nodes(model, positions, hex));
    const double reach = sphere.radius + margin * body_of(model, hex).cell_size;
    for (const ObstacleAt& obstacle : step.obstacles_t1)
      if (signed_distance(*obstacle.shape, obstacle.pose.local(sphere.centre)).distance <= reach) {
        near.push_back(hex);
        break;
      }
  }
  return near;
}

double max_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions, double time) {
  if (model.obstacles.empty()) return 0;
  std::vector<ObstacleAt> obstacles;
  for (const Obstacle& obstacle : model.obstacles) obstacles.push_back(obstacle_at(obstacle, time));
  VectorXd deepest = VectorXd::Zero((model.num_hexes() + hexes_per_block - 1) / hexes_per_block);
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    double& block_deepest = deepest[begin / hexes_per_block];
    for (int hex = int(begin); hex < int(end); ++hex) {
      if (geometry.hex_starts[hex] == geometry.hex_starts[hex + 1]) continue;
      if (!touches_obstacles(model, model.hex_body[hex])) continue;
      const Model::BodyRange& body = body_of(model, hex);
      const Matrix8x3d nodes = hex_nodes(model, positions, hex);
      const BoundingSphere sphere = bounding_sphere(nodes);
      for (const auto& [pose, shape] : obstacles) {
        if (signed_distance(*shape, pose.local(sphere.centre)).distance > sphere.radius) continue;
        const Vector3d half_edges = longest_half_edges(nodes);
        for (int c = geometry.clusters.hex_starts[hex]; c < geometry.clusters.hex_starts[hex + 1]; ++c) {
          const VertexCluster& cluster = geometry.clusters.all[c];
          const ClusterSphere around = sphere_around(cluster, nodes, half_edges);
          if (signed_distance(*shape, pose.local(around.centre)).distance > around.radius - block_deepest) continue;
          fetch_weights(body, geometry.clusters, cluster);
          for (int k = cluster.first; k < cluster.first + cluster.count; ++k) {
            const Vector3d p = nodes.transpose() * surface_weights(body, geometry.clusters.points[k]);
            block_deepest = std::max(block_deepest, -signed_distance(*shape, pose.local(p)).distance);
          }
        }
      }
    }
  });
  return deepest.maxCoeff();
}

}  // namespace umax
