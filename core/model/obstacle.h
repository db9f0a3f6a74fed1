// Obstacles, the things that bodies fall on: shapes with a signed distance, at rest, keyframed, or animated elsewhere.
#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/base/track.h"
#include "core/base/types.h"

namespace umax {

struct RestSurface;
class Deformation;

struct HalfSpace {};  // y <= 0 in the obstacle's own frame
struct Ball {
  double radius = 1;  // [m]
};
struct Block {
  Vector3d half_size{0.5, 0.5, 0.5};  // [m]
};
/// Signed distance sampled on a grid and interpolated trilinearly; filled by embedding/distance_grid.
struct SampledDistance {
  Vector3d origin{0, 0, 0};   // [m] position of sample (0, 0, 0)
  double spacing = 0;         // [m]
  Vector3i size{0, 0, 0};     // samples along x, y, z
  std::vector<float> values;  // [m] negative inside; index (i * size.y + j) * size.z + k
};
struct MeshShape {
  std::shared_ptr<const SampledDistance> distance;
  Points edge_points;  // #P x 3 [m] points along its sharp edges and corners, tested against the body's surface
};
/// Points on edges of triangles, which they move with.
struct EdgeRiders {
  VectorXi from, to;  // #P vertices at the edge's ends
  VectorXd share;     // #P [-] of the way from one to the other
};
/// Triangles, measured exactly: what is animated, at an instant.
struct TriangleShape {
  std::shared_ptr<const RestSurface> surface;
  double thickness = 0;                           // [m] half of it lies on each side of the triangles
  bool is_closed = true;                          // it has an inside; else both sides push
  std::shared_ptr<const EdgeRiders> edge_points;  // along its sharp edges; null: none
};
using ObstacleShape = std::variant<HalfSpace, Ball, Block, MeshShape, TriangleShape>;

struct Obstacle {
  std::string name;
  ObstacleShape shape;
  double friction = 0;                                  // [-] Coulomb coefficient; a pair takes the larger one
  Track<Vector3d> position{Vector3d(0, 0, 0)};          // [m] of the shape's origin
  Track<Vector3d> rotation_degrees{Vector3d(0, 0, 0)};  // about world X, then Y, then Z
  std::shared_ptr<const Deformation> deformation = {};  // of triangles, whose shape is then that at rest; null: none
};

struct Pose {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();
  Vector3d world(const Vector3d& local) const { return rotation * local + translation; }
  Vector3d local(const Vector3d& world) const { return rotation.transpose() * (world - translation); }
};
Pose pose_at(const Obstacle& obstacle, double time);

/// An obstacle at an instant. It must not outlive the obstacle.
struct ObstacleAt {
  Pose pose;
  std::shared_ptr<const ObstacleShape> shape;
};
ObstacleAt obstacle_at(const Obstacle& obstacle, double time);

struct DistanceSample {
  double distance = 0;                    // [m] negative inside
  Vector3d gradient = Vector3d::UnitY();  // unit outward direction
};
/// Distance of a point in the shape's own frame; outside a sampled grid: the distance to the grid's box plus the edge
/// value; of triangles that are not closed: from their nearest side.
DistanceSample signed_distance(const ObstacleShape& shape, const Vector3d& local_point);
DistanceSample signed_distance(const SampledDistance& grid, const Vector3d& point);

/// Highest point of the shape below y = infinity in a vertical column is scene matter; this is its top in world space
/// under the axis-aligned footprint [min, max] (x, z), or -infinity if nothing is below. Used to place drop_height.
double highest_point_below(const Obstacle& obstacle, double time, const Vector3d& footprint_min,
                           const Vector3d& footprint_max);

}  // namespace umax
