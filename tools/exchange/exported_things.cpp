#include "tools/exchange/exported_things.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "core/base/parallel.h"
#include "embedding/surface/shapes.h"

namespace umax {
namespace {

/// Points or directions of the scene in the axes of the export, times a factor.
FloatPoints exported(const Points& vectors, const ExportOptions& options, double factor) {
  FloatPoints out(vectors.rows(), 3);
  parallel_blocks(vectors.rows(), 4096, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const Vector3d v = factor * vectors.row(i).transpose();
      out.row(i) = (options.z_up ? z_up_from_y_up(v) : v).cast<float>().transpose();
    }
  });
  return out;
}

SurfaceMaterial material_of(const Look& look) {
  SurfaceMaterial material;
  material.base_color = look.base_color;
  material.roughness = look.roughness;
  material.metallic = look.metallic;
  material.clearcoat = look.clearcoat;
  material.clearcoat_roughness = look.clearcoat_roughness;
  material.ior = look.ior;
  return material;
}

MovingSurface surface_of(const std::string& name, const TriangleMesh& mesh, const Look& look,
                         const ExportOptions& options) {
  MovingSurface surface;
  surface.name = name;
  surface.rest = exported(mesh.positions, options, options.scale);
  surface.triangles = mesh.triangles;
  surface.texture_coordinates = mesh.texture_coordinates;
  surface.colors = mesh.colors.cast<float>();
  surface.material = material_of(look);
  return surface;
}

/// The picture that the body shows, where it is a file of its own and the only one.
std::filesystem::path texture_file(const BodySetup& body, const BodyDescription& description) {
  if (!body.look.texture) return {};
  if (!description.texture_path.empty()) return description.texture_path;
  const std::vector<MeshMaterial>& materials = body.shape.own->materials;
  return materials.size() == 1 ? materials.front().texture : std::filesystem::path{};
}

ExportedThing body_thing(const Simulation& simulation, std::size_t index, const ExportOptions& options) {
  const BodySetup& body = simulation.bodies[index];
  const BodyDescription& description = simulation.scene.bodies[index];
  ExportedThing thing{.stem = body.name,
                      .body = index,
                      .obstacle = {},
                      .surface = surface_of(body.name, body.shape.mesh, body.look, options),
                      .texture = {}};
  thing.surface.material.library = thing.stem + ".mtl";
  thing.surface.material.vertex_colors = body.look.vertex_colors;
  thing.texture = texture_file(body, description);
  return thing;
}

/// The square that a half space is.
TriangleMesh ground_square(const Simulation& simulation) {
  Eigen::AlignedBox3d box;
  for (const BodySetup& body : simulation.bodies)
    for (const auto& point : body.shape.mesh.positions.rowwise()) box.extend(point.transpose());
  return make_plane(10 * box.diagonal().norm());
}

TriangleMesh mesh_of(const Simulation& simulation, std::size_t obstacle, double time) {
  return simulation.obstacles[obstacle].mesh ? *obstacle_mesh(simulation, obstacle, time) : ground_square(simulation);
}

TriangleMesh moved(const TriangleMesh& mesh, const Pose& pose) {
  TriangleMesh out = mesh;
  out.positions = (mesh.positions * pose.rotation.transpose()).rowwise() + pose.translation.transpose();
  if (mesh.normals.rows() > 0) out.normals = mesh.normals * pose.rotation.transpose();
  return out;
}

ExportedThing obstacle_thing(const Simulation& simulation, std::size_t index, const ExportOptions& options) {
  const ObstacleDescription& description = simulation.scene.obstacles[index];
  const Pose pose = pose_at(simulation.model.obstacles[index], 0);
  ExportedThing thing{
      .stem = "obstacle." + description.name,
      .body = {},
      .obstacle = index,
      .surface = surface_of(description.name, moved(mesh_of(simulation, index, 0), pose), description.look, options),
      .texture = {}};
  thing.surface.material.library = thing.stem + ".mtl";
  thing.surface.moves = !description.position.is_constant() || !description.rotation_degrees.is_constant() ||
                        !description.cache.path.empty();
  return thing;
}

[[noreturn]] void refuse_name(const Scene& scene, const std::string& name) {
  std::vector<std::string> known;
  for (const BodyDescription& body : scene.bodies) known.push_back(body.name);
  for (const ObstacleDescription& obstacle : scene.obstacles) known.push_back("obstacle." + obstacle.name);
  throw Error(Fault::usage, {.where = "--bodies",
                             .what = "the scene has no such body or obstacle",
                             .value = '"' + name + '"',
                             .remedy = "did you mean " + nearest_word(name, known) + "?"});
}

void refuse_unknown_names(const Scene& scene, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto is_it = [&](const auto& thing) { return thing.name == name; };
    if (std::any_of(scene.bodies.begin(), scene.bodies.end(), is_it)) continue;
    const bool is_obstacle = std::any_of(scene.obstacles.begin(), scene.obstacles.end(), [&](const auto& obstacle) {
      return obstacle.name == name || "obstacle." + obstacle.name == name;
    });
    if (!is_obstacle) refuse_name(scene, name);
  }
}

bool is_wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

/// A name alone means the body where there is one.
bool is_wanted_obstacle(const Scene& scene, const std::vector<std::string>& names,
                        const ObstacleDescription& obstacle) {
  if (names.empty()) return obstacle.visible;
  const bool is_body = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                   [&](const BodyDescription& body) { return body.name == obstacle.name; });
  return is_wanted(names, "obstacle." + obstacle.name) || (!is_body && is_wanted(names, obstacle.name));
}

/// Velocities [m/s] of an obstacle's vertices: of its motion, by a central difference.
Points velocities_of(const Simulation& simulation, std::size_t index, double time) {
  constexpr double h = 1e-4;  // [s]
  const auto positions_at = [&](double at) {
    return moved(mesh_of(simulation, index, at), pose_at(simulation.model.obstacles[index], at)).positions;
  };
  return (positions_at(time + h) - positions_at(time - h)) / (2 * h);
}

void sample_body(const Simulation& simulation, const ExportedThing& thing, const ExportOptions& options,
                 const State& state, SurfaceFrame& frame) {
  const BodySetup& body = simulation.bodies[*thing.body];
  const FormatTraits& format = traits_of(options.format);
  const auto of_body = [&](const Points& nodes) {
    return Points(nodes.middleRows(body.first_node, body.lattice.num_nodes()));
  };
  TriangleMesh mesh;
  if (format.has_normals) {
    deform(*body.embedding, body.lattice.hexes, of_body(state.positions), mesh);
    frame.normals = exported(mesh.normals, options, 1);
  } else {
    deform_positions(*body.embedding, body.lattice.hexes, of_body(state.positions), mesh.positions);
  }
  frame.positions = exported(mesh.positions, options, options.scale);
  if (!format.has_velocities) return;
  deform_positions(*body.embedding, body.lattice.hexes, of_body(state.velocities), mesh.positions);
  frame.velocities = exported(mesh.positions, options, options.scale);
}

void sample_obstacle(const Simulation& simulation, const ExportedThing& thing, const ExportOptions& options,
                     const State& state, SurfaceFrame& frame) {
  const Obstacle& obstacle = simulation.model.obstacles[*thing.obstacle];
  const FormatTraits& format = traits_of(options.format);
  TriangleMesh mesh = moved(mesh_of(simulation, *thing.obstacle, state.time), pose_at(obstacle, state.time));
  if (format.has_normals) {
    if (mesh.normals.rows() == 0) compute_normals(mesh);
    frame.normals = exported(mesh.normals, options, 1);
  }
  frame.positions = exported(mesh.positions, options, options.scale);
  if (format.has_velocities)
    frame.velocities = exported(velocities_of(simulation, *thing.obstacle, state.time), options, options.scale);
}

}  // namespace

std::vector<ExportedThing> things_to_export(const Simulation& simulation, const ExportOptions& options) {
  const Scene& scene = simulation.scene;
  refuse_unknown_names(scene, options.things);
  std::vector<ExportedThing> things;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (is_wanted(options.things, scene.bodies[i].name)) things.push_back(body_thing(simulation, i, options));
  if (traits_of(options.format).holds_hexes) {
    if (!things.empty()) return things;
    throw Error(Fault::usage, {.where = "--bodies",
                               .what = "names obstacles alone, which have no cage",
                               .remedy = "name a body, or export another format"});
  }
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i)
    if (is_wanted_obstacle(scene, options.things, scene.obstacles[i]))
      things.push_back(obstacle_thing(simulation, i, options));
  return things;
}

ClipCamera exported_camera(const Camera& camera, const RenderDescription& render, const ExportOptions& options) {
  const auto axes = [&](const Vector3f& v) {
    return options.z_up ? z_up_from_y_up(v.cast<double>()) : v.cast<double>().eval();
  };
  const double to_target = double((camera.target - camera.position).norm());
  return {.position = options.scale * axes(camera.position),
          .target = options.scale * axes(camera.target),
          .up = axes(camera.up),
          .vertical_fov_degrees = double(camera.vertical_fov_degrees),
          .aspect = double(render.width) / render.height,
          .aperture_radius = options.scale * double(camera.aperture_radius),
          .focus_distance = options.scale * (camera.focus_distance > 0 ? double(camera.focus_distance) : to_target)};
}

SurfaceFrame sample(const Simulation& simulation, const ExportedThing& thing, const ExportOptions& options, int number,
                    const State& state) {
  SurfaceFrame frame;
  frame.frame = number;
  frame.time = state.time;
  if (thing.body)
    sample_body(simulation, thing, options, state, frame);
  else
    sample_obstacle(simulation, thing, options, state, frame);
  if (!frame.positions.allFinite() || !frame.velocities.allFinite())
    throw Error(Fault::bad_data, {.where = fmt::format("frame {} of {}", number, thing.stem),
                                  .what = "has coordinates that single precision cannot hold",
                                  .value = fmt::format("--scale {:g}", options.scale),
                                  .remedy = "give a smaller --scale"});
  return frame;
}

}  // namespace umax
