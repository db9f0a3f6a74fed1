#include "tools/setup/simulation_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/model/deformation.h"
#include "core/model/hex_limits.h"
#include "core/problem/linear_plan.h"
#include "embedding/cage/hex_cage.h"
#include "embedding/cameras/moving_camera.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/normals.h"
#include "embedding/surface/placement.h"
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

Vector3d lowest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().minCoeff().transpose();
}
Vector3d highest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().maxCoeff().transpose();
}

/// Moves the mesh up or down until its lowest point is drop_height above the highest obstacle below it.
void apply_drop_height(double drop_height, const std::vector<Obstacle>& obstacles, PlacedMesh& shape) {
  const TriangleMesh& mesh = shape.mesh;
  double top = -std::numeric_limits<double>::infinity();
  for (const Obstacle& obstacle : obstacles)
    top = std::max(top, highest_point_below(obstacle, 0, lowest(mesh), highest(mesh)));
  if (!std::isfinite(top))
    throw Error(Fault::bad_data, {.where = "drop_height",
                                  .what = "there is no obstacle below the body",
                                  .value = fmt::format("{} m", drop_height),
                                  .remedy = "add [obstacle.ground], or give position instead"});
  move_shape(Vector3d(0, top + drop_height - lowest(mesh).y(), 0), shape);
}

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

bool has_same_cage(const CageDescription& a, const CageDescription& b) {
  if (std::holds_alternative<MeshSource>(a.size) || std::holds_alternative<MeshSource>(b.size)) return false;
  const CageOptions options_a = cage_options(a), options_b = cage_options(b);
  return options_a.size == options_b.size && options_a.whole_box == options_b.whole_box;
}

/// The first of the bodies so far that differs from the shape in its place alone; null: none.
const BodySetup* find_twin(const Scene& scene, const std::vector<BodySetup>& caged, const BodyDescription& description,
                           const PlacedMesh& shape) {
  if (shape.hexes) return nullptr;
  for (std::size_t i = 0; i < caged.size(); ++i)
    if (caged[i].shape.own == shape.own && caged[i].shape.world_from_file.linear() == shape.world_from_file.linear() &&
        has_same_cage(scene.bodies[i].cage, description.cage))
      return &caged[i];
  return nullptr;
}

/// What is known of the very body from an earlier scene; null: nothing.
const ShapeLibrary::Cage* find_cage(const ShapeLibrary& library, const BodyDescription& description,
                                    const PlacedMesh& shape) {
  for (const ShapeLibrary::Cage& cage : library.cages)
    if (cage.own == shape.own && cage.world_from_file.matrix() == shape.world_from_file.matrix() &&
        has_same_cage(cage.description, description.cage))
      return &cage;
  return nullptr;
}

/// The twin's cage, moved.
void take_cage(const BodySetup& twin, BodySetup& setup) {
  const Vector3d by = setup.shape.world_from_file.translation() - twin.shape.world_from_file.translation();
  setup.lattice = make_lattice(twin.lattice.cells, twin.lattice.origin + by, twin.lattice.cell_size);
  setup.lattice.filled_fraction = twin.lattice.filled_fraction;
  setup.cage = twin.cage;
  setup.embedding = twin.embedding;
}

BodySetup cage_body(const Scene& scene, const std::vector<BodySetup>& caged, const std::vector<Obstacle>& obstacles,
                    ShapeLibrary& library) {
  const BodyDescription& description = scene.bodies[caged.size()];
  BodySetup setup{.name = description.name,
                  .shape = place_body(description, library),
                  .lattice = {},
                  .cage = {},
                  .embedding = {},
                  .look = {}};
  named("body." + description.name, [&] {
    if (description.drop_height) apply_drop_height(*description.drop_height, obstacles, setup.shape);
    const PlacedMesh& shape = setup.shape;
    if (const BodySetup* twin = find_twin(scene, caged, description, shape)) {
      take_cage(*twin, setup);
      return 0;
    }
    if (const ShapeLibrary::Cage* known = shape.hexes ? nullptr : find_cage(library, description, shape)) {
      setup.lattice = known->lattice;
      setup.cage = known->report;
      setup.embedding = known->embedding;
      return 0;
    }
    setup.lattice = shape.hexes ? make_hex_cage(shape.mesh, shape.hexes->mesh.nodes, shape.hexes->mesh.hexes,
                                                {.is_the_body = shape.hexes->are_the_body()}, &setup.cage)
                                : voxelize(shape.mesh, cage_options(description.cage), &setup.cage);
    setup.embedding = std::make_shared<const Embedding>(embed(setup.shape.mesh, setup.lattice));
    if (library.keeps_cages && !shape.hexes)
      library.cages.push_back(
          {shape.own, shape.world_from_file, description.cage, setup.lattice, setup.cage, setup.embedding});
    return 0;
  });
  return setup;
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

CageOptions cage_options(const CageDescription& cage) {
  CageOptions options{.whole_box = cage.clip == CageDescription::Clip::box};
  if (const int* count = std::get_if<int>(&cage.size)) options.size = *count;
  if (const Vector3i* grid = std::get_if<Vector3i>(&cage.size)) options.size = *grid;
  if (const double* edge = std::get_if<double>(&cage.size)) options.size = *edge;
  return options;
}

Digest digest_of(const Simulation& simulation) {
  const ClipDescription& clip = simulation.scene.clip;
  Digest digest = with_gravity_keys(model_digest(simulation.model, simulation.options), clip.gravity);
  if (!clip.pulls.empty()) digest = sha256_hex(digest + " with pulls " + clip.pulls_sha256);
  if (clip.preroll > 0) digest = sha256_hex(digest + fmt::format(" after {} s", clip.preroll));
  return digest;
}

namespace {

void warn_of_creases(Simulation& simulation) {
  if (simulation.scene.render.surface == SurfaceKernel::trilinear) return;
  for (const BodySetup& body : simulation.bodies)
    if (!body.lattice.is_regular())
      simulation.warnings.push_back("body." + body.name +
                                    ": render.surface is smooth, but is drawn trilinear: the cells of its cage are not "
                                    "equal");
}

}  // namespace

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
