#include "core/model/obstacle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/overloaded.h"
#include "core/element/rotation.h"
#include "core/model/deformation.h"
#include "core/model/rest_surface.h"

namespace umax {
namespace {

DistanceSample distance_to_ball(const Ball& ball, const Vector3d& p) {
  const double length = p.norm();
  return {length - ball.radius, length > 0 ? Vector3d(p / length) : Vector3d(Vector3d::UnitY())};
}

DistanceSample distance_to_block(const Block& block, const Vector3d& p) {
  const Vector3d beyond = p.cwiseAbs() - block.half_size;  // per axis, positive outside that slab
  const Vector3d sign = p.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
  if (beyond.maxCoeff() <= 0) {  // inside: the nearest face
    Eigen::Index axis;
    const double distance = beyond.maxCoeff(&axis);
    return {distance, Vector3d(sign[axis] * Vector3d::Unit(axis))};
  }
  const Vector3d outward = beyond.cwiseMax(0.0).cwiseProduct(sign);
  return {outward.norm(), outward.normalized()};
}

// value and gradient of the trilinear interpolant in the grid cell that holds p (p inside the grid's box)
DistanceSample interpolate(const SampledDistance& grid, const Vector3d& p) {
  const Vector3d scaled = (p - grid.origin) / grid.spacing;
  Vector3i cell;
  for (int axis = 0; axis < 3; ++axis) cell[axis] = std::clamp(int(std::floor(scaled[axis])), 0, grid.size[axis] - 2);
  const Vector3d t = scaled - cell.cast<double>();
  double value = 0;
  Vector3d gradient = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) {
    const int i = n >> 2 & 1, j = n >> 1 & 1, k = n & 1;
    const std::size_t index =
        (std::size_t(cell[0] + i) * grid.size[1] + (cell[1] + j)) * std::size_t(grid.size[2]) + (cell[2] + k);
    const double sample = double(grid.values[index]);
    const double wx = i ? t[0] : 1 - t[0], wy = j ? t[1] : 1 - t[1], wz = k ? t[2] : 1 - t[2];
    value += sample * wx * wy * wz;
    gradient += sample * Vector3d((i ? 1 : -1) * wy * wz, (j ? 1 : -1) * wx * wz, (k ? 1 : -1) * wx * wy);
  }
  const double length = gradient.norm();
  return {value, length > 0 ? Vector3d(gradient / length) : Vector3d(Vector3d::UnitY())};
}

DistanceSample distance_to_triangles(const TriangleShape& shape, const Vector3d& p) {
  const SurfaceHit hit = nearest_point(*shape.surface, p, std::numeric_limits<double>::infinity());
  const bool turns = !shape.is_closed && hit.distance < 0;
  return {(turns ? -hit.distance : hit.distance) - shape.thickness / 2, turns ? Vector3d(-hit.normal) : hit.normal};
}

}  // namespace

Pose pose_at(const Obstacle& obstacle, double time) {
  return {rotation_from_degrees(obstacle.rotation_degrees.at(time)), obstacle.position.at(time)};
}

ObstacleAt obstacle_at(const Obstacle& obstacle, double time) {
  // a shape that stays belongs to the obstacle
  return {pose_at(obstacle, time),
          obstacle.deformation ? obstacle.deformation->shape_at(time)
                               : std::shared_ptr<const ObstacleShape>(std::shared_ptr<void>(), &obstacle.shape)};
}

DistanceSample signed_distance(const SampledDistance& grid, const Vector3d& point) {
  const Vector3d last = grid.origin + grid.spacing * (grid.size.cast<double>() - Vector3d::Ones());
  const Vector3d inside = point.cwiseMax(grid.origin).cwiseMin(last);
  DistanceSample sample = interpolate(grid, inside);
  const Vector3d away = point - inside;
  if (away.squaredNorm() > 0) {
    sample.distance += away.norm();
    sample.gradient = away.normalized();
  }
  return sample;
}

DistanceSample signed_distance(const ObstacleShape& shape, const Vector3d& p) {
  return std::visit(Overloaded{[&](const HalfSpace&) { return DistanceSample{p.y(), Vector3d::UnitY()}; },
                               [&](const Ball& ball) { return distance_to_ball(ball, p); },
                               [&](const Block& block) { return distance_to_block(block, p); },
                               [&](const MeshShape& mesh) { return signed_distance(*mesh.distance, p); },
                               [&](const TriangleShape& triangles) { return distance_to_triangles(triangles, p); }},
                    shape);
}

double highest_point_below(const Obstacle& obstacle, double time, const Vector3d& footprint_min,
                           const Vector3d& footprint_max) {
  const auto [pose, shape] = obstacle_at(obstacle, time);
  if (std::holds_alternative<HalfSpace>(obstacle.shape)) {
    // highest corner of the footprint on the tilted plane; a vertical plane has no top
    const Vector3d normal = pose.rotation.col(1);
    if (normal.y() < 1e-6) return -std::numeric_limits<double>::infinity();
    double top = -std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner & 1 ? footprint_max.x() : footprint_min.x();
      const double z = corner & 2 ? footprint_max.z() : footprint_min.z();
      const Vector3d d(x - pose.translation.x(), 0, z - pose.translation.z());
      top = std::max(top, pose.translation.y() - (normal.x() * d.x() + normal.z() * d.z()) / normal.y());
    }
    return top;
  }
  // closed shapes: march rays downwards on a grid over the footprint by the signed distance
  const double high = std::max(footprint_max.y(), pose.translation.y()) + 1e3;
  double top = -std::numeric_limits<double>::infinity();
  constexpr int samples = 33;
  for (int a = 0; a < samples; ++a)
    for (int b = 0; b < samples; ++b) {
      Vector3d p(footprint_min.x() + (footprint_max.x() - footprint_min.x()) * a / (samples - 1), high,
                 footprint_min.z() + (footprint_max.z() - footprint_min.z()) * b / (samples - 1));
      for (int march = 0; march < 200 && p.y() > top && p.y() > -1e4; ++march) {
        const double distance = signed_distance(*shape, pose.local(p)).distance;
        if (distance < 1e-6) {
          top = p.y();
          break;
        }
        p.y() -= distance;
      }
    }
  return top;
}

}  // namespace umax
