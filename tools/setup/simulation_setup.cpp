#include "tools/setup/simulation_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/model/deformation.h"
#include "core/model/hex_limits.h"
#include "core/problem/linear_plan.h"
#include "embedding/cameras/moving_camera.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/normals.h"
#include "embedding/surface/placement.h"
#include "tools/setup/body_cage.h"
#include "tools/setup/body_contact.h"
#include "tools/setup/body_look.h"
#include "tools/setup/body_maps.h"
#include "tools/setup/body_pins.h"
#include "tools/setup/contact_points.h"
#include "tools/setup/limit_report.h"
#include "tools/setup/named_error.h"
#include "tools/setup/studio.h"

namespace umax {
namespace {

std::vector<int> nodes_in_boxes(const std::vector<FixedBox>& boxes, const Lattice& lattice) {
  std::vector<int> nodes;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::size_t before = nodes.size();
    for (int node = 0; node < int(lattice.num_nodes()); ++node) {
      const auto position = lattice.rest_positions.row(node).transpose().array();
      if ((position >= boxes[i].min.array()).all() && (position <= boxes[i].max.array()).all()) nodes.push_back(node);
    }
    if (nodes.size() > before) continue;
    const Vector3d low = lattice.rest_positions.colwise().minCoeff(),
                   high = lattice.rest_positions.colwise().maxCoeff();
    throw Error(Fault::bad_data,
                {.where = "fixed",
                 .what = fmt::format("box {} holds no node of the cage", i + 1),
                 .value = fmt::format("[{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}]", boxes[i].min.x(), boxes[i].min.y(),
                                      boxes[i].min.z(), boxes[i].max.x(), boxes[i].max.y(), boxes[i].max.z()),
                 .remedy = fmt::format("the cage reaches from [{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] m", low.x(),
                                       low.y(), low.z(), high.x(), high.y(), high.z())});
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

Body make_body(const BodyDescription& description, const BodySetup& setup, bool needs_distance) {
  Body body;
  body.name = description.name;
  body.lattice = setup.lattice;
  body.material = description.material;
  body.limit = description.limit;
  body.part_limits = description.part_limits;
  body.friction = description.friction;
  body.contact = description.contact;
  body.velocity = description.velocity;
  body.spin = description.spin_degrees * (EIGEN_PI / 180);
  body.fixed_nodes =
      named("body." + description.name, [&] { return nodes_in_boxes(description.fixed, setup.lattice); });
  if (setup.shape.hexes) {
    body.young_factor = setup.shape.hexes->mesh.young_factor;
    body.limit_factor = setup.shape.hexes->mesh.limit_factor;
  }
  body.surface = points_of(*setup.embedding);
  if (needs_distance)
    body.rest_distance = std::make_shared<const SampledDistance>(make_distance_grid(setup.shape.mesh));
  return body;
}

bool has_edges(const Obstacle& obstacle) {
  const auto* triangles = std::get_if<TriangleShape>(&obstacle.shape);
  return std::holds_alternative<Block>(obstacle.shape) || std::holds_alternative<MeshShape>(obstacle.shape) ||
         (triangles && triangles->edge_points && triangles->edge_points->share.size() > 0);
}

/// The probes in their bodies' lattices, with the model's hex numbers.
EmbeddedPoints embed_probes(const Scene& scene, const std::vector<BodySetup>& bodies) {
  EmbeddedPoints all;
  const auto count = Eigen::Index(scene.probes.size());
  all.hex.resize(count);
  all.weights.resize(count, 8);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ProbeDescription& probe = scene.probes[std::size_t(i)];
    const auto body =
        std::find_if(bodies.begin(), bodies.end(), [&](const BodySetup& b) { return b.name == probe.body; });
    named("probe." + probe.name, [&] {
      if (body == bodies.end())
        throw Error(Fault::bad_data, {.where = "body",
                                      .what = "there is no such body",
                                      .value = probe.body,
                                      .remedy = "name a body of the scene"});
      const EmbeddedPoints one = embed_points(Points(probe.point.transpose()), body->lattice, "probe");
      all.hex[i] = one.hex[0] + int(body->first_hex);
      all.weights.row(i) = one.weights.row(0);
      return 0;
    });
  }
  return all;
}

/// Says which bodies start inside an obstacle, and how deep.
void warn_of_penetration(const Simulation& simulation, std::vector<std::string>& warnings) {
  for (const BodySetup& body : simulation.bodies)
    for (const Obstacle& obstacle : simulation.model.obstacles) {
      const auto [pose, shape] = obstacle_at(obstacle, 0);
      double deepest = 0;
      for (const auto& point : body.shape.mesh.positions.rowwise())
        deepest = std::min(deepest, signed_distance(*shape, pose.local(point.transpose())).distance);
      if (deepest < -1e-6)
        warnings.push_back(
            fmt::format("body.{} starts {:.4g} m deep inside obstacle.{} and will be pushed out slowly; raise its "
                        "position to avoid it",
                        body.name, -deepest, obstacle.name));
    }
}

void warn_of_creases(Simulation& simulation) {
  if (simulation.scene.render.surface == SurfaceKernel::trilinear) return;
  for (const BodySetup& body : simulation.bodies)
    if (!body.lattice.is_regular())
      simulation.warnings.push_back("body." + body.name +
                                    ": render.surface is smooth, but is drawn trilinear: the cells of its cage are not "
                                    "equal");
}

void read_pulls(Simulation& simulation) {
  const std::filesystem::path& path = simulation.scene.clip.pulls;
  if (path.empty()) return;
  simulation.pulls = decode_pulls(read_file(path), path.string(), simulation.model);
  if (!simulation.pulls.empty() && simulation.options.solver.linear == LinearSolver::multigrid)
    throw Error(Fault::bad_data, {.where = "solver.linear",
                                  .what = "is multigrid, which knows no springs, but clip.pulls holds some",
                                  .remedy = "leave solver.linear out"});
}

void read_camera(CameraDescription& camera) {
  if (camera.file.empty()) return;
  camera.motion = std::make_shared<const MovingCamera>(read_moving_camera(camera.file, camera.name));
}

}  // namespace

Digest digest_of(const Simulation& simulation) {
  const ClipDescription& clip = simulation.scene.clip;
  Digest digest = with_gravity_keys(model_digest(simulation.model, simulation.options), clip.gravity);
  if (!clip.pulls.empty()) digest = sha256_hex(digest + " with pulls " + clip.pulls_sha256);
  if (clip.preroll > 0) digest = sha256_hex(digest + fmt::format(" after {} s", clip.preroll));
  return digest;
}

Simulation set_up(const Scene& scene, const CageWatch& watch) {
  ShapeLibrary library;
  return set_up(scene, library, watch);
}

Simulation set_up(const Scene& scene, ShapeLibrary& library, const CageWatch& watch) {
  library.surfaces.clear();
  Simulation simulation;
  simulation.scene = scene;
  read_camera(simulation.scene.camera);
  simulation.options.time_step = scene.clip.time_step();
  simulation.options.gravity = scene.clip.gravity.at(0);
  simulation.options.solver = scene.solver;

  std::vector<Obstacle> obstacles;
  for (const ObstacleDescription& description : scene.obstacles)
    obstacles.push_back(make_obstacle(description, scene.clip, simulation.obstacles.emplace_back(), library));
  for (std::size_t i = 0; i < obstacles.size(); ++i)
    for (const std::string& note : simulation.obstacles[i].notes)
      simulation.warnings.push_back("obstacle." + obstacles[i].name + ": " + note);

  const bool needs_distance = std::any_of(obstacles.begin(), obstacles.end(), has_edges);
  const std::vector<char> is_touched = touched_bodies(scene);
  std::vector<Body> bodies;
  for (const BodyDescription& description : scene.bodies) {
    BodySetup& setup = simulation.bodies.emplace_back(cage_body(scene, simulation.bodies, obstacles, library));
    if (watch) watch(simulation.bodies);
    for (const std::string& note : setup.shape.notes) simulation.warnings.push_back("body." + setup.name + ": " + note);
    for (const std::string& note : setup.cage.notes) simulation.warnings.push_back("body." + setup.name + ": " + note);
    setup.look = body_look(description, setup.shape, library, simulation.warnings);
    bodies.push_back(make_body(description, setup, needs_distance));
    if (is_touched[bodies.size() - 1]) {
      bodies.back().rest_surface = rest_surface(setup.shape, library, bodies.back().rest_scale);
      bodies.back().rest_pose = rest_pose(setup.shape);
      append(points_between_vertices(setup, bodies.back()), bodies.back().surface);
    }
    apply_maps(description, setup, bodies.back(), simulation.warnings);
    bodies.back().pins = body_pins(scene,
                                   {.name = setup.name,
                                    .shape = setup.shape,
                                    .lattice = setup.lattice,
                                    .embedding = *setup.embedding,
                                    .young = description.material.young.at(0)},
                                   setup.notes, simulation.warnings);
  }
  simulation.model = make_model(std::move(bodies), obstacles, make_pairs(scene));
  require_measurable(simulation.model, scene.solver.energy);
  require_solvable(plan_linear_solvers(simulation.model, scene.solver), scene.solver);
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i) {
    simulation.bodies[i].first_node = simulation.model.bodies[i].first_node;
    simulation.bodies[i].first_hex = simulation.model.bodies[i].first_hex;
  }
  simulation.probes = embed_probes(scene, simulation.bodies);
  read_pulls(simulation);
  simulation.digest = digest_of(simulation);
  Eigen::AlignedBox3d box;
  for (const BodySetup& body : simulation.bodies)
    for (const auto& place : body.shape.mesh.positions.rowwise()) box.extend(Vector3d(place.transpose()));
  light_scene(box, simulation.scene);
  warn_of_penetration(simulation, simulation.warnings);
  warn_of_fast_animations(simulation.model, simulation.options.time_step, simulation.warnings);
  warn_of_open_meshes(simulation.model, simulation.warnings);
  warn_of_paper_method(simulation.model, scene.solver.method, simulation.warnings);
  warn_of_overlaps(simulation.model, simulation.warnings);
  warn_of_creases(simulation);
  warn_of_sudden_limits(simulation, simulation.warnings);
  return simulation;
}

std::shared_ptr<const TriangleMesh> obstacle_mesh(const Simulation& simulation, std::size_t obstacle, double time) {
  const auto& rest = simulation.obstacles[obstacle].mesh;
  const auto& deformation = simulation.model.obstacles[obstacle].deformation;
  if (!deformation) return rest;
  auto mesh = std::make_shared<TriangleMesh>(*rest);
  mesh->positions = positions_at(deformation->motion(), time);
  compute_normals(*mesh);
  return mesh;
}

std::vector<Vector3d> probe_positions(const Simulation& simulation, const Points& nodes) {
  const Points points = deform_points(simulation.probes, simulation.model.hexes, nodes);
  std::vector<Vector3d> positions;
  for (const auto& point : points.rowwise()) positions.emplace_back(point.transpose());
  return positions;
}

std::vector<std::string> probe_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const ProbeDescription& probe : scene.probes) names.push_back(probe.name);
  return names;
}

}  // namespace umax
