#include "core/contact.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace umax {
namespace {

// no surface vertex may end a step deeper than this share of the cell size
constexpr double penetration_tolerance = 1e-3;
constexpr Eigen::Index hexes_per_block = 64;
constexpr int max_edge_intervals = 2000;
// an obstacle's edge pushes within 60 degrees of its mean normal, not on sides that it merely runs through
constexpr double edge_cone_cosine = 0.5;

struct BoundingSphere {
  Vector3d centre;
  double radius;
};

// trilinear maps stay in the convex hull of the nodes, so the sphere holds every point of the hex
BoundingSphere bounding_sphere(const Matrix8x3d& nodes) {
  const Vector3d centre = nodes.colwise().mean().transpose();
  return {centre, std::sqrt((nodes.rowwise() - centre.transpose()).rowwise().squaredNorm().maxCoeff())};
}

Vector3d surface_position(const Model& model, const Matrix8x3d& nodes, int point) {
  return nodes.transpose() * model.surface.weights.row(point).transpose();
}

// depths [m] that a vertex may have at the end of the step, by how deep it was at the start
struct AllowedDepth {
  double deep = 0;     // of a start beyond the tolerance: pushed out at a bounded speed, not at once
  double shallow = 0;  // of a start within it: left as it is, since pushing it out would do work
};

AllowedDepth allowed_depth(const ContactStep& step, int obstacle, int hex, const Vector8d& weights) {
  const Vector3d before = embedded_position(*step.model, step.positions_t0, hex, weights);
  const double depth =
      -signed_distance(step.model->obstacles[obstacle].shape, step.poses_t0[obstacle].local(before)).distance;
  if (depth <= tolerance_depth(*step.model, hex)) return {0, std::max(0.0, depth)};
  return {std::max(0.0, depth - step.recovery[step.model->hex_body[hex]]), 0};
}

// distance of a vertex at the end of the step and the outward direction, in the world
DistanceSample end_distance(const ContactStep& step, int obstacle, const Vector3d& position) {
  const Pose& pose = step.poses_t1[obstacle];
  DistanceSample sample = signed_distance(step.model->obstacles[obstacle].shape, pose.local(position));
  sample.gradient = pose.rotation * sample.gradient;
  return sample;
}

// an obstacle's edge point seen from the material of a hex
struct EdgeHit {
  Vector8d weights = Vector8d::Zero();
  double gap = 0;  // [m] negative under the body's surface
  Vector3d normal = Vector3d::UnitY();
};

// a hex and this much of its size around it: trilinear maps continue there
constexpr double own = 1 + 1e-9, around = 2;

// local coordinates s with sum_n N_n(s) x_n = point, by Newton's method; false if |s| > reach
bool invert_trilinear(const Matrix8x3d& nodes, const Vector3d& point, double reach, Vector3d& s) {
  s.setZero();
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Vector3d residual = nodes.transpose() * shape_functions(s) - point;
    const Matrix3d jacobian = nodes.transpose() * shape_gradients(s);
    if (!(std::abs(jacobian.determinant()) > 0)) return false;
    const Vector3d change = jacobian.inverse() * residual;
    s -= change;
    if (!(s.cwiseAbs().maxCoeff() < 4)) return false;
    if (change.cwiseAbs().maxCoeff() < 1e-12) return s.cwiseAbs().maxCoeff() <= reach;
  }
  return false;
}

// phi(X(P)): rest distance of the material at P; moving the material by n moves phi by -|F^-T grad phi|
bool edge_hit(const Model& model, const Points& positions, int hex, const Vector3d& point, double reach, EdgeHit& hit) {
  const Matrix8x3d nodes = hex_nodes(model, positions, hex);
  Vector3d s;
  if (!invert_trilinear(nodes, point, reach, s)) return false;
  const Matrix8x3d rest = hex_nodes(model, model.rest_positions, hex);
  hit.weights = shape_functions(s);
  const SampledDistance& distance = *model.bodies[model.hex_body[hex]].rest_distance;
  const DistanceSample phi = signed_distance(distance, rest.transpose() * hit.weights);
  const Matrix8x3d gradients = shape_gradients(s);
  const Matrix3d F = (nodes.transpose() * gradients) * (rest.transpose() * gradients).inverse();
  if (!(F.determinant() > 0)) return false;
  const Vector3d pulled = F.inverse().transpose() * phi.gradient;
  hit.gap = phi.distance / pulled.norm();
  hit.normal = -pulled.normalized();
  return true;
}

Vector3d obstacle_point_motion(const ContactStep& step, int obstacle, const Vector3d& position_t1) {
  const Vector3d local = step.poses_t1[obstacle].local(position_t1);
  return position_t1 - step.poses_t0[obstacle].world(local);
}

double pair_friction(const Model& model, int hex, int obstacle) {
  return std::max(model.bodies[model.hex_body[hex]].friction, model.obstacles[obstacle].friction);
}

void place_vertex_contact(const ContactStep& step, const Points& positions, Contact& contact) {
  const Vector3d position = embedded_position(*step.model, positions, contact.hex, contact.weights);
  const DistanceSample sample = end_distance(step, contact.obstacle, position);
  const AllowedDepth allowed = allowed_depth(step, contact.obstacle, contact.hex, contact.weights);
  contact.gap = sample.distance + allowed.deep + allowed.shallow;
  contact.position = position;
  contact.normal = sample.gradient;
  contact.obstacle_motion = obstacle_point_motion(step, contact.obstacle, position);
}

// an obstacle's edge point at the end of the step
struct WorldEdge {
  Vector3d point, normal;
};
WorldEdge world_edge(const ContactStep& step, int obstacle, int k) {
  const EdgePoints& edges = step.geometry->edges[obstacle];
  const Pose& pose = step.poses_t1[obstacle];
  return {pose.world(edges.positions.row(k).transpose()), pose.rotation * edges.normals.row(k).transpose()};
}

// the hex of a body that holds a point; -1: none
int holding_hex(const ContactStep& step, const Points& positions, const Model::BodyRange& body, const Vector3d& point,
                EdgeHit& hit) {
  for (int hex = body.first_hex; hex < body.first_hex + body.num_hexes; ++hex) {
    const BoundingSphere sphere = bounding_sphere(hex_nodes(*step.model, positions, hex));
    if ((point - sphere.centre).squaredNorm() > sphere.radius * sphere.radius) continue;
    if (edge_hit(*step.model, positions, hex, point, own, hit)) return hex;
  }
  return -1;
}

// an edge point that has left the cage is still measured from the hex that it left
void place_edge_contact(const ContactStep& step, const Points& positions, Contact& contact) {
  const WorldEdge edge = world_edge(step, contact.obstacle, -1 - contact.point);
  contact.obstacle_motion = obstacle_point_motion(step, contact.obstacle, edge.point);
  EdgeHit hit;
  bool found = edge_hit(*step.model, positions, contact.hex, edge.point, own, hit);
  if (!found) {
    const int hex =
        holding_hex(step, positions, step.model->bodies[step.model->hex_body[contact.hex]], edge.point, hit);
    if (hex >= 0) contact.hex = hex;
    found = hex >= 0 || edge_hit(*step.model, positions, contact.hex, edge.point, around, hit);
  }
  if (!found) {  // far away: the gap to where it last was
    const Vector3d material = embedded_position(*step.model, positions, contact.hex, contact.weights);
    contact.gap = (material - edge.point).dot(contact.normal);
    return;
  }
  contact.weights = hit.weights;
  contact.gap = hit.gap;
  contact.normal = hit.normal;
}

void append(const ContactStep& step, const Points& positions, int point, int obstacle, int hex, const Vector8d& weights,
            std::vector<Contact>& contacts) {
  Contact contact;
  contact.point = point;
  contact.obstacle = obstacle;
  contact.hex = hex;
  contact.weights = weights;
  contact.friction = pair_friction(*step.model, hex, obstacle);
  contacts.push_back(contact);
  if (point >= 0)
    place_vertex_contact(step, positions, contacts.back());
  else
    place_edge_contact(step, positions, contacts.back());
}

bool in_set(const std::vector<Contact>& contacts, std::size_t count, int point, int obstacle) {
  for (std::size_t i = 0; i < count; ++i)
    if (contacts[i].point == point && contacts[i].obstacle == obstacle) return true;
  return false;
}

struct Candidate {
  int point = 0, obstacle = 0, hex = 0;
  double gap = 0;
};

// the deepest vertex of one hex against one obstacle, if any is below -threshold
bool deepest_vertex(const ContactStep& step, const Matrix8x3d& nodes, const BoundingSphere& sphere, int hex,
                    int obstacle, double threshold, Candidate& deepest) {
  const Model& model = *step.model;
  const ContactGeometry& geometry = *step.geometry;
  const double centre_distance =
      signed_distance(model.obstacles[obstacle].shape, step.poses_t1[obstacle].local(sphere.centre)).distance;
  if (centre_distance > sphere.radius) return false;
  deepest = {-1, obstacle, hex, -threshold};
  for (int k = geometry.hex_starts[hex]; k < geometry.hex_starts[hex + 1]; ++k) {
    const int point = geometry.hex_points[k];
    double gap = end_distance(step, obstacle, surface_position(model, nodes, point)).distance;
    if (gap < deepest.gap) gap += allowed_depth(step, obstacle, hex, model.surface.weights.row(point).transpose()).deep;
    if (gap < deepest.gap) deepest.point = point, deepest.gap = gap;
  }
  return deepest.point >= 0;
}

std::vector<Candidate> vertex_candidates(const ContactStep& step, const Points& positions, double share) {
  const Model& model = *step.model;
  const Eigen::Index num_blocks = (model.num_hexes() + hexes_per_block - 1) / hexes_per_block;
  std::vector<std::vector<Candidate>> per_block(num_blocks);
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (int hex = int(begin); hex < int(end); ++hex) {
      if (step.geometry->hex_starts[hex] == step.geometry->hex_starts[hex + 1]) continue;
      const Matrix8x3d nodes = hex_nodes(model, positions, hex);
      const BoundingSphere sphere = bounding_sphere(nodes);
      Candidate candidate;
      for (int obstacle = 0; obstacle < int(model.obstacles.size()); ++obstacle)
        if (deepest_vertex(step, nodes, sphere, hex, obstacle, share * tolerance_depth(model, hex), candidate))
          per_block[begin / hexes_per_block].push_back(candidate);
    }
  });
  std::vector<Candidate> all;
  for (const std::vector<Candidate>& block : per_block) all.insert(all.end(), block.begin(), block.end());
  return all;
}

void keep_deepest(const Candidate& candidate, std::vector<Candidate>& deepest) {
  const auto same = std::find_if(deepest.begin(), deepest.end(), [&](const Candidate& c) {
    return c.hex == candidate.hex && c.obstacle == candidate.obstacle;
  });
  if (same == deepest.end())
    deepest.push_back(candidate);
  else if (candidate.gap < same->gap)
    *same = candidate;
}

// edge points of obstacles that stick in a body: the deepest per hex and obstacle
std::vector<Candidate> edge_candidates(const ContactStep& step, const Points& positions, double share) {
  const Model& model = *step.model;
  std::vector<Candidate> deepest;
  for (const Model::BodyRange& body : model.bodies) {
    if (!body.rest_distance) continue;
    const auto nodes = positions.middleRows(body.first_node, body.num_nodes);
    const Vector3d low = nodes.colwise().minCoeff().transpose(), high = nodes.colwise().maxCoeff().transpose();
    for (int obstacle = 0; obstacle < int(model.obstacles.size()); ++obstacle)
      for (int k = 0; k < int(step.geometry->edges[obstacle].positions.rows()); ++k) {
        const WorldEdge edge = world_edge(step, obstacle, k);
        if ((edge.point.array() < low.array()).any() || (edge.point.array() > high.array()).any()) continue;
        EdgeHit hit;
        const int hex = holding_hex(step, positions, body, edge.point, hit);
        if (hex >= 0 && hit.gap < -share * tolerance_depth(model, hex) &&
            hit.normal.dot(edge.normal) >= edge_cone_cosine)
          keep_deepest({-1 - k, obstacle, hex, hit.gap}, deepest);
      }
  }
  return deepest;
}

// corners and points along the 12 edges, each with the mean normal of the faces that meet there
EdgePoints block_edge_points(const Block& block, double spacing) {
  std::vector<Vector3d> points;
  for (int axis = 0; axis < 3; ++axis) {
    const int intervals = std::clamp(int(std::ceil(2 * block.half_size[axis] / spacing)), 1, max_edge_intervals);
    for (int edge = 0; edge < 4; ++edge)
      for (int i = axis == 0 ? 0 : 1; i <= intervals - (axis == 0 ? 0 : 1); ++i) {
        Vector3d point;
        point[axis] = 2.0 * i / intervals - 1;
        point[(axis + 1) % 3] = edge & 1 ? 1 : -1;
        point[(axis + 2) % 3] = edge & 2 ? 1 : -1;
        points.push_back(point);
      }
  }
  EdgePoints edges{Points(Eigen::Index(points.size()), 3), Points(Eigen::Index(points.size()), 3)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d faces = points[i].unaryExpr([](double v) { return std::abs(v) == 1 ? v : 0.0; });
    edges.positions.row(Eigen::Index(i)) = points[i].cwiseProduct(block.half_size).transpose();
    edges.normals.row(Eigen::Index(i)) = faces.normalized().transpose();
  }
  return edges;
}

// the sampled distance is rounded at edges: its gradient there is their mean normal
EdgePoints mesh_edge_points(const MeshShape& mesh) {
  EdgePoints edges{mesh.edge_points, Points(mesh.edge_points.rows(), 3)};
  for (Eigen::Index i = 0; i < mesh.edge_points.rows(); ++i)
    edges.normals.row(i) = signed_distance(*mesh.distance, mesh.edge_points.row(i).transpose()).gradient.transpose();
  return edges;
}

// half the speed of a fall through one cell, or a small share of the speed of sound where nothing falls: gentle at any
// scale
double recovery_speed(const Model::BodyRange& body, double gravity, double time) {
  const double sound = std::sqrt(body.material.young.at(time) / body.material.density);
  return std::max(0.5 * std::sqrt(gravity * body.cell_size), 0.01 * sound);
}

}  // namespace

double tolerance_depth(const Model& model, int hex) {
  return penetration_tolerance * model.bodies[model.hex_body[hex]].cell_size;
}

Vector3d embedded_position(const Model& model, const Points& positions, int hex, const Vector8d& weights) {
  Vector3d position = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) position += weights[n] * positions.row(model.hexes(hex, n)).transpose();
  return position;
}

ContactGeometry make_contact_geometry(const Model& model) {
  ContactGeometry geometry;
  geometry.hex_starts.assign(model.num_hexes() + 1, 0);
  for (Eigen::Index p = 0; p < model.surface.size(); ++p) ++geometry.hex_starts[model.surface.hex[p] + 1];
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) geometry.hex_starts[e + 1] += geometry.hex_starts[e];
  geometry.hex_points.resize(model.surface.size());
  std::vector<int> next(geometry.hex_starts.begin(), geometry.hex_starts.end() - 1);
  for (Eigen::Index p = 0; p < model.surface.size(); ++p) geometry.hex_points[next[model.surface.hex[p]]++] = int(p);

  double cell_size = std::numeric_limits<double>::infinity();
  for (const Model::BodyRange& body : model.bodies) cell_size = std::min(cell_size, body.cell_size);
  for (const Obstacle& obstacle : model.obstacles) {
    EdgePoints edges{Points(0, 3), Points(0, 3)};
    if (const Block* block = std::get_if<Block>(&obstacle.shape)) edges = block_edge_points(*block, cell_size / 6);
    if (const MeshShape* mesh = std::get_if<MeshShape>(&obstacle.shape)) edges = mesh_edge_points(*mesh);
    geometry.edges.push_back(edges);
  }
  return geometry;
}

ContactStep begin_contact_step(const Model& model, const ContactGeometry& geometry, const Points& positions_t0,
                               double time_t0, double time_step, double gravity) {
  ContactStep step;
  step.model = &model;
  step.geometry = &geometry;
  step.positions_t0 = positions_t0;
  for (const Obstacle& obstacle : model.obstacles) {
    step.poses_t0.push_back(pose_at(obstacle, time_t0));
    step.poses_t1.push_back(pose_at(obstacle, time_t0 + time_step));
  }
  for (const Model::BodyRange& body : model.bodies)
    step.recovery.push_back(time_step * recovery_speed(body, gravity, time_t0));
  return step;
}

void update_contacts(const ContactStep& step, const Points& positions, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) {
    if (contact.point >= 0)
      place_vertex_contact(step, positions, contact);
    else
      place_edge_contact(step, positions, contact);
  }
}

void follow_contacts(const ContactStep& step, const Points& positions, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) {
    const Vector3d position = embedded_position(*step.model, positions, contact.hex, contact.weights);
    contact.gap += contact.normal.dot(position - contact.position);
    contact.position = position;
  }
}

int add_contacts(const ContactStep& step, const Points& positions, double share, std::vector<Contact>& contacts) {
  const std::size_t known = contacts.size();
  std::vector<Candidate> candidates = vertex_candidates(step, positions, share);
  const std::vector<Candidate> edges = edge_candidates(step, positions, share);
  candidates.insert(candidates.end(), edges.begin(), edges.end());
  for (const Candidate& candidate : candidates) {
    if (in_set(contacts, known, candidate.point, candidate.obstacle)) continue;
    const Vector8d weights = candidate.point >= 0
                                 ? Vector8d(step.model->surface.weights.row(candidate.point).transpose())
                                 : Vector8d::Constant(0.125);
    append(step, positions, candidate.point, candidate.obstacle, candidate.hex, weights, contacts);
  }
  return int(contacts.size() - known);
}

double max_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions, double time) {
  if (model.obstacles.empty()) return 0;
  std::vector<Pose> poses;
  for (const Obstacle& obstacle : model.obstacles) poses.push_back(pose_at(obstacle, time));
  VectorXd deepest = VectorXd::Zero((model.num_hexes() + hexes_per_block - 1) / hexes_per_block);
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    double& block_deepest = deepest[begin / hexes_per_block];
    for (int hex = int(begin); hex < int(end); ++hex) {
      if (geometry.hex_starts[hex] == geometry.hex_starts[hex + 1]) continue;
      const Matrix8x3d nodes = hex_nodes(model, positions, hex);
      const BoundingSphere sphere = bounding_sphere(nodes);
      for (std::size_t o = 0; o < poses.size(); ++o) {
        const ObstacleShape& shape = model.obstacles[o].shape;
        if (signed_distance(shape, poses[o].local(sphere.centre)).distance > sphere.radius) continue;
        for (int k = geometry.hex_starts[hex]; k < geometry.hex_starts[hex + 1]; ++k) {
          const Vector3d p = surface_position(model, nodes, geometry.hex_points[k]);
          block_deepest = std::max(block_deepest, -signed_distance(shape, poses[o].local(p)).distance);
        }
      }
    }
  });
  return deepest.maxCoeff();
}

}  // namespace umax
