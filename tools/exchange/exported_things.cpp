#include "tools/exchange/exported_things.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

MovingSurface surface_of(const std::string& name, const std::string& stem, const TriangleMesh& mesh, const Look& look,
                         const ExportOptions& options) {
  MovingSurface surface;
  surface.name = name;
  surface.library = stem + ".mtl";
  surface.rest = exported(mesh.positions, options, options.scale);
  surface.triangles = mesh.triangles;
  surface.texture_coordinates = mesh.texture_coordinates;
  surface.colors = mesh.colors.cast<float>();
  surface.materials = {material_of(look)};
  surface.materials[0].name = name;
  return surface;
}

ExportedTexture texture_of(const MeshMaterial& material, const OwnShape& own) {
  if (material.embedded_texture < 0) return {material.texture, nullptr};
  return {{}, &own.embedded_textures[std::size_t(material.embedded_texture)]};
}

/// What the body shows where it has one material.
ExportedTexture only_texture(const BodySetup& body, const BodyDescription& description) {
  if (!body.look.texture) return {};
  if (!description.texture_path.empty()) return {description.texture_path, nullptr};
  return texture_of(body.shape.own->materials.front(), *body.shape.own);
}

/// The materials of the body's file, where it is drawn with several.
void add_materials(const BodySetup& body, ExportedThing& thing) {
  const OwnShape& own = *body.shape.own;
  const SurfaceMaterial common = thing.surface.materials.front();
  std::vector<std::string> names;
  for (const MeshMaterial& material : own.materials) names.push_back(material.name);
  names = material_names(names);
  thing.surface.materials.clear();
  thing.textures.clear();
  for (std::size_t i = 0; i < own.materials.size(); ++i) {
    const Paint& paint = body.look.paints[i];
    SurfaceMaterial material = common;
    material.name = names[i];
    material.base_color = paint.base_color;
    thing.surface.materials.push_back(material);
    thing.textures.push_back(paint.texture ? texture_of(own.materials[i], own) : ExportedTexture{});
  }
  thing.surface.triangle_materials = body.shape.mesh.materials;
}

/// Which places of the file's the body's own vertices leave free.
std::vector<int> places_between(const std::vector<int>& taken, Eigen::Index count) {
  std::vector<int> free;
  std::size_t next = 0;
  for (int place = 0; place < int(count); ++place) {
    if (next < taken.size() && taken[next] == place)
      ++next;
    else
      free.push_back(place);
  }
  return free;
}

/// Values of the body's own vertices and of the loose ones, each where the file has it.
FloatPoints in_file_order(const ExportedThing& thing, const FloatPoints& own, const FloatPoints& loose) {
  if (thing.vertex_in_file.empty()) return own;
  FloatPoints out(own.rows() + loose.rows(), 3);
  for (Eigen::Index v = 0; v < own.rows(); ++v) out.row(thing.vertex_in_file[std::size_t(v)]) = own.row(v);
  for (Eigen::Index v = 0; v < loose.rows(); ++v) out.row(thing.loose_in_file[std::size_t(v)]) = loose.row(v);
  return out;
}

/// The vertices of the file that no triangle has come back to their places.
void add_loose_vertices(const BodySetup& body, const ExportOptions& options, ExportedThing& thing) {
  const OwnShape& own = *body.shape.own;
  if (own.vertex_in_file.empty()) return;
  const Eigen::Affine3d& place = body.shape.world_from_file;
  Points rest = (own.loose_vertices * place.linear().transpose()).rowwise() + place.translation().transpose();
  // what is no number has no place: it goes with the hex that is nearest to the origin
  rest = rest.unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; }).eval();
  thing.vertex_in_file = own.vertex_in_file;
  thing.loose_in_file = places_between(own.vertex_in_file, own.mesh.num_vertices() + rest.rows());
  thing.loose = tie_loose_vertices(rest, body.lattice);

  MovingSurface& surface = thing.surface;
  surface.rest = in_file_order(thing, surface.rest, exported(rest, options, options.scale));
  if (surface.colors.rows() > 0) surface.colors = in_file_order(thing, surface.colors, own.loose_colors.cast<float>());
  for (int& corner : surface.triangles.reshaped()) corner = own.vertex_in_file[std::size_t(corner)];
}

ExportedThing body_thing(const Simulation& simulation, std::size_t index, const ExportOptions& options) {
  const BodySetup& body = simulation.bodies[index];
  const BodyDescription& description = simulation.scene.bodies[index];
  ExportedThing thing{.stem = body.name,
                      .body = index,
                      .obstacle = {},
                      .surface = surface_of(body.name, body.name, body.shape.mesh, body.look, options),
                      .textures = {only_texture(body, description)},
                      .vertex_in_file = {},
                      .loose_in_file = {},
                      .loose = {}};
  thing.surface.materials[0].vertex_colors = body.look.vertex_colors;
  if (!body.look.paints.empty()) add_materials(body, thing);
  add_loose_vertices(body, options, thing);
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
  const std::string stem = "obstacle." + description.name;
  ExportedThing thing{.stem = stem,
                      .body = {},
                      .obstacle = index,
                      .surface = surface_of(description.name, stem, moved(mesh_of(simulation, index, 0), pose),
                                            description.look, options),
                      .textures = {{}},
                      .vertex_in_file = {},
                      .loose_in_file = {},
                      .loose = {}};
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

/// Velocities [m/s] of the vertices that no triangle has: by a central difference along those of the nodes.
Points loose_velocities(const ExportedThing& thing, const Lattice& lattice, const Points& nodes,
                        const Points& velocities) {
  constexpr double h = 1e-4;  // [s]
  return (deform_loose_vertices(thing.loose, lattice, nodes + h * velocities) -
          deform_loose_vertices(thing.loose, lattice, nodes - h * velocities)) /
         (2 * h);
}

void sample_body(const Simulation& simulation, const ExportedThing& thing, const ExportOptions& options,
                 const State& state, SurfaceFrame& frame) {
  const BodySetup& body = simulation.bodies[*thing.body];
  const FormatTraits& format = traits_of(options.format);
  const auto of_body = [&](const Points& nodes) {
    return Points(nodes.middleRows(body.first_node, body.lattice.num_nodes()));
  };
  const auto in_order = [&](const Points& own, const Points& loose, double factor) {
    return in_file_order(thing, exported(own, options, factor), exported(loose, options, factor));
  };
  const Points nodes = of_body(state.positions);
  TriangleMesh mesh;
  if (format.has_normals) {
    deform(*body.embedding, body.lattice.hexes, nodes, mesh);
    const Points upwards = Vector3d::UnitY().transpose().replicate(thing.loose.size(), 1);
    frame.normals = in_order(mesh.normals, upwards, 1);
  } else {
    deform_positions(*body.embedding, body.lattice.hexes, nodes, mesh.positions);
  }
  frame.positions = in_order(mesh.positions, deform_loose_vertices(thing.loose, body.lattice, nodes), options.scale);
  if (!format.has_velocities) return;
  const Points velocities = of_body(state.velocities);
  deform_positions(*body.embedding, body.lattice.hexes, velocities, mesh.positions);
  frame.velocities = in_order(mesh.positions, loose_velocities(thing, body.lattice, nodes, velocities), options.scale);
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
