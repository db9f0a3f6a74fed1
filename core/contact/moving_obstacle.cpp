#include "core/contact/moving_obstacle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/rest_surface.h"

namespace umax {
namespace {

const RestSurface* animated_surface(const ObstacleAt& obstacle) {
  const auto* triangles = std::get_if<TriangleShape>(obstacle.shape.get());
  return triangles ? triangles->surface.get() : nullptr;
}

// shares of a triangle's corners in a point of it
Vector3d corner_shares(const RestSurface& surface, int triangle, const Vector3d& point) {
  const Vector3d a = corner_of(surface, triangle, 0), ab = corner_of(surface, triangle, 1) - a,
                 ac = corner_of(surface, triangle, 2) - a, ap = point - a;
  const double bb = ab.dot(ab), bc = ab.dot(ac), cc = ac.dot(ac), determinant = bb * cc - bc * bc;
  if (!(determinant > 0)) return {1, 0, 0};
  const double b = (cc * ab.dot(ap) - bc * ac.dot(ap)) / determinant,
               c = (bb * ac.dot(ap) - bc * ab.dot(ap)) / determinant;
  return {1 - b - c, b, c};
}

// from where to where the triangles' point moves that is nearest to a place on `here`
Vector3d way_beside(const RestSurface& here, const RestSurface& there, const Vector3d& place) {
  const SurfaceHit hit = nearest_point(here, place, std::numeric_limits<double>::infinity());
  if (hit.triangle < 0) return Vector3d::Zero();
  const Vector3d shares = corner_shares(here, hit.triangle, hit.point);
  Vector3d way = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) way += shares[k] * (corner_of(there, hit.triangle, k) - corner_of(here, hit.triangle, k));
  return way;
}

// in the world, vertex by vertex
Points vertices_of(const ObstacleAt& obstacle, const RestSurface& surface) {
  return (surface.vertices * obstacle.pose.rotation.transpose()).rowwise() + obstacle.pose.translation.transpose();
}

// the longest way [m] of a corner of those triangles that come into a box
double way_into(const Eigen::AlignedBox3d& box, const Triangles& triangles, const Points& from, const Points& to) {
  double longest = 0;
  for (const auto& corners : triangles.rowwise()) {
    Eigen::AlignedBox3d way;
    double farthest = 0;
    for (const int v : corners) {
      way.extend(from.row(v).transpose());
      way.extend(to.row(v).transpose());
      farthest = std::max(farthest, (to.row(v) - from.row(v)).squaredNorm());
    }
    if (farthest > longest && way.intersects(box)) longest = farthest;
  }
  return std::sqrt(longest);
}

}  // namespace

Vector3d obstacle_point_motion(const ContactStep& step, int obstacle, const Vector3d& position_t1) {
  const ObstacleAt &from = step.obstacles_t0[obstacle], &to = step.obstacles_t1[obstacle];
  const Vector3d local = to.pose.local(position_t1);
  if (from.shape == to.shape || !animated_surface(to)) return position_t1 - from.pose.world(local);
  const Vector3d back = way_beside(*animated_surface(to), *animated_surface(from), local);
  return position_t1 - from.pose.world(local + back);
}

Vector3d carried_along(const ContactStep& step, int obstacle, const Vector3d& local_t0) {
  const ObstacleAt &from = step.obstacles_t0[obstacle], &to = step.obstacles_t1[obstacle];
  if (from.shape == to.shape || !animated_surface(to)) return local_t0;
  return local_t0 + way_beside(*animated_surface(from), *animated_surface(to), local_t0);
}

double largest_deformation(const ObstacleAt& from, const ObstacleAt& to) {
  if (from.shape == to.shape || !animated_surface(to)) return 0;
  return std::sqrt(
      (animated_surface(to)->vertices - animated_surface(from)->vertices).rowwise().squaredNorm().maxCoeff());
}

double animated_way(const Model& model, const Points& positions, const Points& expected, double time,
                    double time_step) {
  double longest = 0;
  for (const Obstacle& obstacle : model.obstacles) {
    if (!obstacle.deformation) continue;
    const ObstacleAt from = obstacle_at(obstacle, time), to = obstacle_at(obstacle, time + time_step);
    const Points before = vertices_of(from, *animated_surface(from)), after = vertices_of(to, *animated_surface(to));
    const Triangles& triangles = animated_surface(to)->triangles;
    for (int b = 0; b < int(model.bodies.size()); ++b) {
      if (!touches_obstacles(model, b)) continue;
      const Model::BodyRange& body = model.bodies[b];
      Eigen::AlignedBox3d box;
      for (const Points* at : {&positions, &expected})
        for (const auto& node : at->middleRows(body.first_node, body.num_nodes).rowwise()) box.extend(node.transpose());
      box.min().array() -= body.cell_size, box.max().array() += body.cell_size;
      longest = std::max(longest, way_into(box, triangles, before, after) / body.cell_size);
    }
  }
  return longest;
}

}  // namespace umax
