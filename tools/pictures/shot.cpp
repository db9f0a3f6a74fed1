#include "tools/pictures/shot.h"

#include <algorithm>
#include <numbers>
#include <utility>
#include <vector>

#include "embedding/surface/hex_faces.h"
#include "embedding/surface/shapes.h"
#include "render/annotation/annotate.h"
#include "render/image/image_io.h"
#include "tools/pictures/drawn_surface.h"

namespace umax {
namespace {

Sky read_sky(const RenderDescription& render) {
  if (const auto* map = std::get_if<EnvironmentMap>(&render.sky)) {
    EnvironmentMap loaded = *map;
    if (!loaded.image) loaded.image = std::make_shared<const Image>(read_image(render.sky_path));
    return loaded;
  }
  return render.sky;
}

/// The hexes' values at a body's vertices: of the hex that holds it, unsmoothed, so that a limit that is reached looks
/// like one; of a vertex that is a node, the largest of its hexes.
VectorXd values_at_vertices(const BodySetup& body, const VectorXd& heat) {
  const VectorXi& hex = body.embedding->hex;
  VectorXd values(hex.size());
  for (Eigen::Index p = 0; p < hex.size(); ++p) values[p] = heat[body.first_hex + hex[p]];
  if (!body.shape.hexes || !body.shape.hexes->are_the_body()) return values;
  VectorXd of_nodes = VectorXd::Zero(body.lattice.num_nodes());
  for (Eigen::Index e = 0; e < body.lattice.num_hexes(); ++e)
    for (const int node : body.lattice.hexes.row(e))
      of_nodes[node] = std::max(of_nodes[node], heat[body.first_hex + e]);
  for (Eigen::Index p = 0; p < hex.size(); ++p) values[p] = of_nodes[body.shape.hexes->surface_nodes[std::size_t(p)]];
  return values;
}

Points heat_colors(const BodySetup& body, const VectorXd& heat, const Legend& legend) {
  const VectorXd values = values_at_vertices(body, heat);
  Points colors(values.size(), 3);
  for (Eigen::Index p = 0; p < values.size(); ++p)
    colors.row(p) = color_on(legend, values[p]).cast<double>().transpose();
  return colors;
}

/// heat: of all hexes, read from the legend; without one it is not looked at.
RenderObject draw_body(const Simulation& simulation, std::size_t index, const State& state, const VectorXd& heat,
                       const std::optional<Legend>& legend) {
  const BodySetup& body = simulation.bodies[index];
  auto mesh = std::make_shared<TriangleMesh>(body.shape.mesh);
  draw_surface(simulation, body, state.positions.middleRows(body.first_node, body.lattice.num_nodes()), *mesh);

  RenderObject object{.name = body.name, .mesh = mesh, .look = body.look};
  if (legend) {
    mesh->colors = heat_colors(body, heat, *legend);
    object.look = Look();
    object.look.roughness = 0.6f;
    object.look.vertex_colors = true;
  }
  return object;
}

/// U/U_max at the vertices of the bodies, which are the shot's first objects.
void add_energy(const Simulation& simulation, const State& state, RenderScene& shot) {
  const VectorXd energy = heat_values(simulation, state, Heatmap::energy);
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i) {
    const VectorXd values = values_at_vertices(simulation.bodies[i], energy);
    shot.objects[i].values.assign(values.data(), values.data() + values.size());
  }
}

WireOverlay draw_cage(const Stage& stage, const Points& nodes) {
  WireOverlay wires;
  wires.segments.reserve(stage.cage_edges.size());
  for (const auto& [a, b] : stage.cage_edges)
    wires.segments.emplace_back(nodes.row(a).transpose().cast<float>(), nodes.row(b).transpose().cast<float>());
  return wires;
}

/// From a tenth of the way on: seen from low above the ground, most of what is far away is a thin band.
std::optional<Fade> fade_of(const ObstacleDescription& obstacle, const Pose& pose) {
  if (!obstacle.fade) return std::nullopt;
  const float end = float(*obstacle.fade);
  return Fade{.center = pose.translation.cast<float>(), .begin = 0.1f * end, .end = end};
}

void draw_obstacles(const Simulation& simulation, const Stage& stage, double time, RenderScene& shot) {
  for (std::size_t i = 0; i < simulation.obstacles.size(); ++i) {
    const ObstacleDescription& description = simulation.scene.obstacles[i];
    if (!description.visible) continue;
    const Pose pose = pose_at(simulation.model.obstacles[i], time);
    shot.objects.push_back(
        {.name = "obstacle." + description.name,
         .mesh = std::make_shared<const TriangleMesh>(moved(*obstacle_surface(simulation, stage, i, time), pose)),
         .look = simulation.obstacles[i].look,
         .catches_shadows = description.shadow_catcher,
         .fade = fade_of(description, pose)});
  }
}

}  // namespace

TriangleMesh moved(const TriangleMesh& mesh, const Pose& pose) {
  TriangleMesh out = mesh;
  out.positions = (mesh.positions * pose.rotation.transpose()).rowwise() + pose.translation.transpose();
  if (mesh.normals.rows() > 0) out.normals = mesh.normals * pose.rotation.transpose();
  return out;
}

std::shared_ptr<const TriangleMesh> obstacle_surface(const Simulation& simulation, const Stage& stage,
                                                     std::size_t obstacle, double time) {
  return simulation.obstacles[obstacle].mesh ? obstacle_mesh(simulation, obstacle, time) : stage.ground;
}

AreaLight area_light(const LightDescription& description, double time) {
  const Vector3d position = description.position.at(time);
  const double size = description.size.at(time);
  const Vector3d forward = (description.target.at(time) - position).normalized();
  const Vector3d helper = std::abs(forward.y()) < 0.99 ? Vector3d::UnitY() : Vector3d::UnitX();
  // it shines on the side of cross(u, v): along forward
  const Vector3d u = helper.cross(forward).normalized() * size;
  const Vector3d v = forward.cross(u);
  const double radiance = description.power.at(time) / (std::numbers::pi * size * size);
  AreaLight light;
  light.corner = (position - 0.5 * u - 0.5 * v).cast<float>();
  light.edge_u = u.cast<float>();
  light.edge_v = v.cast<float>();
  light.radiance = (radiance * description.color.at(time)).cast<float>();
  return light;
}

Points surface_points(const BodySetup& body, const Points& nodes) {
  return deform_points(points_of(*body.embedding), body.lattice.hexes,
                       nodes.middleRows(body.first_node, body.lattice.num_nodes()));
}

Box box_of(const BodySetup& body, const Points& nodes) {
  const Points points = surface_points(body, nodes);
  return {Vector3d(points.colwise().minCoeff().transpose()), Vector3d(points.colwise().maxCoeff().transpose())};
}

Box box_of(const Simulation& simulation, const Points& nodes) {
  Box box;
  for (const BodySetup& body : simulation.bodies) box.extend(box_of(body, nodes));
  return box;
}

Stage make_stage(const Simulation& simulation, const Box& box, const HeatRange& range) {
  Stage stage;
  stage.sky = read_sky(simulation.scene.render);
  stage.ground = std::make_shared<const TriangleMesh>(make_plane(60 * box.diagonal().norm()));
  if (simulation.scene.render.wireframe) stage.cage_edges = outer_edges(simulation.model.hexes);
  stage.legend = heat_legend(simulation, range);
  return stage;
}

RenderScene make_shot(const Simulation& simulation, const Stage& stage, const State& state, const Camera& camera) {
  return make_shot(simulation, stage, state, camera, heat_values(simulation, state));
}

RenderScene make_shot(const Simulation& simulation, const Stage& stage, const State& state, const Camera& camera,
                      const VectorXd& values) {
  const RenderDescription& render = simulation.scene.render;
  RenderScene shot;
  for (const LightDescription& light : simulation.scene.lights) shot.lights.push_back(area_light(light, state.time));
  shot.sky = stage.sky;
  shot.backdrop = render.backdrop;
  shot.camera = camera;
  shot.exposure_stops = float(render.exposure_stops);
  shot.legend = stage.legend;
  shot.transparent = render.transparent;

  for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
    shot.objects.push_back(draw_body(simulation, i, state, values, stage.legend));
  if (render.has_layer(PictureLayer::energy)) add_energy(simulation, state, shot);
  draw_obstacles(simulation, stage, state.time, shot);
  if (!stage.cage_edges.empty()) shot.wires = draw_cage(stage, state.positions);
  return shot;
}

}  // namespace umax
