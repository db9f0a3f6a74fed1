#include "core/contact/edge_contact.h"

#include <algorithm>
#include <cmath>

#include "core/contact/material_point.h"
#include "core/contact/moving_obstacle.h"
#include "core/model/rest_surface.h"

namespace umax {
namespace {

constexpr int max_edge_intervals = 2000;
// an obstacle's edge pushes within 60 degrees of its mean normal, not on sides that it merely runs through
constexpr double edge_cone_cosine = 0.5;

// an obstacle's edge point seen from the material of a hex
struct EdgeHit {
  Vector8d weights = Vector8d::Zero();
  double gap = 0;  // [m] negative under the body's surface
  Vector3d normal = Vector3d::UnitY();
};

// phi(X(P)): rest distance of the material at P; moving the material by n moves phi by -|F^-T grad phi|
bool edge_hit(const Model& model, const Points& positions, int hex, const Vector3d& point, double reach, EdgeHit& hit) {
  MaterialPoint material;
  if (!find_material(hex_maps(model, positions, hex), point, reach, material)) return false;
  const DistanceSample phi = signed_distance(*body_of(model, hex).rest_distance, material.rest);
  const Vector3d pulled = material.F_inverse.transpose() * phi.gradient;
  hit.weights = material.weights;
  hit.gap = phi.distance / pulled.norm();
  hit.normal = -pulled.normalized();
  return true;
}

// a point that rides on an edge of triangles, in their frame
struct RiderAt {
  Vector3d place, normal;
};
RiderAt rider_at(const EdgeRiders& riders, const RestSurface& surface, int k) {
  const double share = riders.share[k];
  const auto between = [&](const Points& of_vertices) -> Vector3d {
    return ((1 - share) * of_vertices.row(riders.from[k]) + share * of_vertices.row(riders.to[k])).transpose();
  };
  return {between(surface.vertices), between(surface.vertex_normals).normalized()};
}

// an obstacle's edge point at the end of the step
struct WorldEdge {
  Vector3d point, normal;
};
WorldEdge world_edge(const ContactStep& step, int obstacle, int k) {
  const EdgePoints& edges = step.geometry->edges[obstacle];
  const auto& [pose, shape] = step.obstacles_t1[obstacle];
  if (edges.riders) {
    const RiderAt rider = rider_at(*edges.riders, *std::get<TriangleShape>(*shape).surface, k);
    return {pose.world(rider.place), pose.rotation * rider.normal};
  }
  return {pose.world(edges.positions.row(k).transpose()), pose.rotation * edges.normals.row(k).transpose()};
}

std::vector<BoundingSphere> bounding_spheres(const Model& model, const Points& positions,
                                             const Model::BodyRange& body) {
  std::vector<BoundingSphere> spheres(body.num_hexes);
  for (int i = 0; i < body.num_hexes; ++i)
    spheres[i] = bounding_sphere(hex_nodes(model, positions, body.first_hex + i));
  return spheres;
}

// the hex of a body that holds a point; -1: none
int holding_hex(const ContactStep& step, const Points& positions, const Model::BodyRange& body,
                const std::vector<BoundingSphere>& spheres, const Vector3d& point, EdgeHit& hit) {
  for (int i = 0; i < body.num_hexes; ++i) {
    if ((point - spheres[i].centre).squaredNorm() > spheres[i].radius * spheres[i].radius) continue;
    const int hex = body.first_hex + i;
    if (edge_hit(*step.model, positions, hex, point, within_hex, hit)) return hex;
  }
  return -1;
}

void keep_deepest(const Model& model, const ContactCandidate& candidate, std::vector<ContactCandidate>& deepest) {
  const auto same = std::find_if(deepest.begin(), deepest.end(), [&](const ContactCandidate& c) {
    return c.hex == candidate.hex && c.obstacle == candidate.obstacle;
  });
  if (same == deepest.end())
    deepest.push_back(candidate);
  else if (candidate.gap < same->gap - tied_depth(model, candidate.hex))
    *same = candidate;
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

EdgePoints riding_edge_points(const TriangleShape& shape) {
  if (!shape.edge_points) return {Points(0, 3), Points(0, 3)};
  const Eigen::Index count = shape.edge_points->share.size();
  EdgePoints edges{Points(count, 3), Points(count, 3), shape.edge_points};
  for (int k = 0; k < int(count); ++k) {
    const RiderAt rider = rider_at(*shape.edge_points, *shape.surface, k);
    edges.positions.row(k) = rider.place.transpose();
    edges.normals.row(k) = rider.normal.transpose();
  }
  return edges;
}

}  // namespace

EdgePoints edge_points(const ObstacleShape& shape, double spacing) {
  if (const Block* block = std::get_if<Block>(&shape)) return block_edge_points(*block, spacing);
  if (const MeshShape* mesh = std::get_if<MeshShape>(&shape)) return mesh_edge_points(*mesh);
  if (const TriangleShape* triangles = std::get_if<TriangleShape>(&shape)) return riding_edge_points(*triangles);
  return {Points(0, 3), Points(0, 3)};
}

std::vector<ContactCandidate> edge_candidates(const ContactStep& step, const Points& positions, double share) {
  const Model& model = *step.model;
  std::vector<ContactCandidate> deepest;
  for (const Model::BodyRange& body : model.bodies) {
    if (!body.rest_distance || body.contact == ContactWith::none) continue;
    const auto nodes = positions.middleRows(body.first_node, body.num_nodes);
    const Vector3d low = nodes.colwise().minCoeff().transpose(), high = nodes.colwise().maxCoeff().transpose();
    std::vector<BoundingSphere> spheres;  // made when the first edge point comes near
    for (int obstacle = 0; obstacle < int(model.obstacles.size()); ++obstacle)
      for (int k = 0; k < int(step.geometry->edges[obstacle].positions.rows()); ++k) {
        const WorldEdge edge = world_edge(step, obstacle, k);
        if ((edge.point.array() < low.array()).any() || (edge.point.array() > high.array()).any()) continue;
        EdgeHit hit;
        if (spheres.empty()) spheres = bounding_spheres(model, positions, body);
        const int hex = holding_hex(step, positions, body, spheres, edge.point, hit);
        if (hex >= 0 && hit.gap < -share * tolerance_depth(model, hex) &&
            hit.normal.dot(edge.normal) >= edge_cone_cosine)
          keep_deepest(model, {{ContactKind::obstacle_edge, k}, obstacle, hex, hit.gap}, deepest);
      }
  }
  return deepest;
}

void place_edge_contact(const ContactStep& step, const Points& positions, Contact& contact) {
  const WorldEdge edge = world_edge(step, contact.obstacle, contact.point.index);
  contact.obstacle_motion = obstacle_point_motion(step, contact.obstacle, edge.point);
  EdgeHit hit;
  bool found = edge_hit(*step.model, positions, contact.support.hex, edge.point, within_hex, hit);
  if (!found) {
    const Model::BodyRange& body = step.model->bodies[step.model->hex_body[contact.support.hex]];
    const int hex = holding_hex(step, positions, body, bounding_spheres(*step.model, positions, body), edge.point, hit);
    if (hex >= 0) contact.support.hex = hex;
    found = hex >= 0 || edge_hit(*step.model, positions, contact.support.hex, edge.point, around_hex, hit);
  }
  if (!found) {  // far away: the gap to where it last was
    const Vector3d material = embedded_position(*step.model, positions, contact.support);
    contact.gap = (material - edge.point).dot(contact.normal);
    contact.position = material;
    return;
  }
  contact.support.weights = hit.weights;
  contact.gap = hit.gap;
  contact.position = edge.point;
  contact.normal = hit.normal;
}

}  // namespace umax
