#include "tools/setup/obstacle_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/model/deformation.h"
#include "embedding/surface/contact_surface.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/normals.h"
#include "embedding/surface/placement.h"
#include "embedding/surface/shapes.h"
#include "embedding/surface/wall_thickness.h"
#include "tools/setup/animated_mesh.h"
#include "tools/setup/body_look.h"
#include "tools/setup/named_error.h"

namespace umax {
namespace {

Vector3d extent_of(const TriangleMesh& mesh) {
  return (mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff()).transpose();
}

// Samples of a mesh's distance along its longest side: as many as tell its walls' two sides apart.
int distance_samples(const TriangleMesh& mesh, double extent, ObstacleSetup& setup) {
  constexpr int most_samples = 384;
  constexpr double samples_in_wall = 2.5;
  const DistanceGridOptions usual;
  const TriangleMesh border = contact_surface(mesh);
  if (border.num_triangles() == 0) return usual.max_samples_per_axis;
  const auto told = [&](int samples) { return samples_in_wall * extent / samples; };  // [m] thinnest wall
  const double thickness =
      wall_thickness(make_rest_surface(border.positions, border.triangles), told(usual.max_samples_per_axis));
  if (thickness >= told(usual.max_samples_per_axis)) return usual.max_samples_per_axis;
  if (thickness < told(most_samples))
    setup.notes.push_back(
        fmt::format("it has walls of {:.2g} m, and those thinner than {:.2g} m may let bodies through; "
                    "make them thicker, or give its parts as obstacles of their own",
                    thickness, told(most_samples)));
  return std::min(most_samples, int(std::ceil(samples_in_wall * extent / thickness)));
}

// an obstacle whose distance is sampled from a mesh
void take_mesh(TriangleMesh mesh, Obstacle& obstacle, ObstacleSetup& setup) {
  const double extent = extent_of(mesh).maxCoeff();
  MeshShape shape;
  shape.distance = std::make_shared<const SampledDistance>(
      make_distance_grid(mesh, {.max_samples_per_axis = distance_samples(mesh, extent, setup)}));
  shape.edge_points = sharp_edge_points(mesh, {.spacing = extent / 100});
  obstacle.shape = std::move(shape);
  setup.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
}

// an obstacle of the mesh that the description names
void place_mesh(const ObstacleDescription& description, const ClipDescription& clip, Obstacle& obstacle,
                ObstacleSetup& setup, ShapeLibrary& library) {
  const auto own = own_shape(std::get<MeshSource>(description.shape), library);
  TriangleMesh mesh = own->mesh;
  const Placed placed = place(
      mesh,
      {.unit = own->unit, .up = own->up, .height = description.height, .scale = description.scale, .position = {}});
  compute_normals(mesh);
  if (description.cache.path.empty()) return take_mesh(std::move(mesh), obstacle, setup);
  const FileVertices vertices{mesh.num_vertices(), own->vertex_in_file,
                              mesh.num_vertices() + own->loose_vertices.rows(), own->mesh.triangles};
  MeshMotion motion = read_motion(description.cache, vertices, placed.placed_from_own, clip, setup.notes);
  animate(mesh, std::move(motion), description.thickness, obstacle, setup.notes);
  setup.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
}

}  // namespace

Obstacle make_obstacle(const ObstacleDescription& description, const ClipDescription& clip, ObstacleSetup& setup,
                       ShapeLibrary& library) {
  Obstacle obstacle;
  obstacle.name = description.name;
  obstacle.friction = description.friction;
  obstacle.position = description.position;
  obstacle.rotation_degrees = description.rotation_degrees;
  if (const auto* half_space = std::get_if<HalfSpace>(&description.shape)) {
    obstacle.shape = *half_space;
  } else if (const auto* ball = std::get_if<Ball>(&description.shape)) {
    obstacle.shape = *ball;
    setup.mesh = std::make_shared<const TriangleMesh>(make_sphere(ball->radius));
  } else if (const auto* block = std::get_if<Block>(&description.shape)) {
    obstacle.shape = *block;
    setup.mesh = std::make_shared<const TriangleMesh>(make_box(2 * block->half_size));
  } else if (const auto* bowl = std::get_if<BowlShape>(&description.shape)) {
    take_mesh(named("obstacle." + description.name, [&] { return make_bowl(bowl->radius, bowl->thickness); }), obstacle,
              setup);
  } else {
    named("obstacle." + description.name, [&] {
      place_mesh(description, clip, obstacle, setup, library);
      return 0;
    });
  }
  setup.look = drawable_look(description.look, setup.mesh.get(), setup.notes);
  return obstacle;
}

void warn_of_fast_animations(const Model& model, double time_step, std::vector<std::string>& warnings) {
  double cell = std::numeric_limits<double>::infinity();
  for (int b = 0; b < int(model.bodies.size()); ++b)
    if (touches_obstacles(model, b)) cell = std::min(cell, model.bodies[b].cell_size);
  for (const Obstacle& obstacle : model.obstacles) {
    const double speed = obstacle.deformation ? largest_speed(obstacle.deformation->motion()) : 0;
    if (speed * time_step <= cell) continue;
    warnings.push_back(
        fmt::format("obstacle.{} moves by up to {:.3g} m/s, {:.2g} cells in a step: where it comes near "
                    "a body, a step is made of several (column substeps of steps.csv); more "
                    "clip.substeps avoid it",
                    obstacle.name, speed, speed * time_step / cell));
  }
}

}  // namespace umax
