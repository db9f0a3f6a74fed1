#include "tools/setup/simulation_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/model/hex_limits.h"
#include "core/problem/linear_plan.h"
#include "embedding/cage/hex_cage.h"
#include "embedding/figure/figure.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/placement.h"
#include "embedding/surface/shapes.h"
#include "render/image/image_io.h"
#include "tools/setup/body_maps.h"
#include "tools/setup/limit_report.h"
#include "tools/setup/named_error.h"

namespace umax {
namespace {

PlacedMesh read_hexes(const std::filesystem::path& path) {
  HexMesh hexes = load_hex_mesh(path);
  HexSurface surface = surface_of(hexes.nodes, hexes.hexes);
  std::vector<std::string> notes = hexes.notes;
  return {.mesh = std::move(surface.mesh),
          .texture = {},
          .notes = std::move(notes),
          .hexes = PlacedHexes{std::move(hexes), std::move(surface.nodes)}};
}

PlacedMesh read_shape(const MeshSource& source, Placement& placement) {
  if (is_hex_mesh_file(source.path)) {
    placement.unit = source.unit;
    placement.up = source.up;
    return read_hexes(source.path);
  }
  MeshFile file = load_mesh(source.path);
  placement.unit = source.unit ? source.unit : file.unit;
  placement.up = source.up ? source.up : file.up;
  return {std::move(file.mesh), std::move(file.texture), std::move(file.notes), file.num_parts};
}
PlacedMesh read_shape(const BoxShape& box, Placement&) {
  return {.mesh = make_box(box.size), .texture = {}, .notes = {}};
}
PlacedMesh read_shape(const SphereShape& sphere, Placement&) {
  return {.mesh = make_sphere(sphere.radius), .texture = {}, .notes = {}};
}
PlacedMesh read_shape(const CylinderShape& cylinder, Placement&) {
  return {.mesh = make_cylinder(cylinder.radius, cylinder.length), .texture = {}, .notes = {}};
}
PlacedMesh read_shape(const FigureShape&, Placement&) {
  return {.mesh = make_figure(), .texture = {}, .notes = {}};
}

Vector3d lowest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().minCoeff().transpose();
}
Vector3d highest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().maxCoeff().transpose();
}

/// Reads cage.mesh. Its notes become the shape's.
void read_cage_mesh(const MeshSource& source, PlacedMesh& shape) {
  shape.hexes = PlacedHexes{load_hex_mesh(source.path), {}};
  shape.notes.insert(shape.notes.end(), shape.hexes->mesh.notes.begin(), shape.hexes->mesh.notes.end());
}

/// Vertices that are nodes stand where their nodes stand, to the last bit.
void tie_to_nodes(PlacedMesh& shape) {
  if (!shape.hexes) return;
  const std::vector<int>& nodes = shape.hexes->surface_nodes;
  for (std::size_t v = 0; v < nodes.size(); ++v)
    shape.mesh.positions.row(Eigen::Index(v)) = shape.hexes->mesh.nodes.row(nodes[v]);
}

/// Moves the mesh up or down until its lowest point is drop_height above the highest obstacle below it.
void apply_drop_height(double drop_height, const std::vector<Obstacle>& obstacles, PlacedMesh& shape) {
  TriangleMesh& mesh = shape.mesh;
  double top = -std::numeric_limits<double>::infinity();
  for (const Obstacle& obstacle : obstacles)
    top = std::max(top, highest_point_below(obstacle, 0, lowest(mesh), highest(mesh)));
  if (!std::isfinite(top))
    throw Error(Fault::bad_data, {.where = "drop_height",
                                  .what = "there is no obstacle below the body",
                                  .value = fmt::format("{} m", drop_height),
                                  .remedy = "add [obstacle.ground], or give position instead"});
  const double by = top + drop_height - lowest(mesh).y();
  shape.world_from_file.pretranslate(Vector3d(0, by, 0));
  mesh.positions.col(1).array() += by;
  if (shape.hexes) shape.hexes->mesh.nodes.col(1).array() += by;
  tie_to_nodes(shape);
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

std::shared_ptr<const Image> read_texture(const BodyDescription& description, const PlacedMesh& shape,
                                          std::vector<std::string>& warnings) {
  const bool chosen = !description.texture_path.empty();
  const std::filesystem::path& path = chosen ? description.texture_path : shape.texture;
  std::error_code error;
  if (path.empty()) return nullptr;
  if (shape.mesh.texture_coordinates.rows() == 0) {
    if (chosen)
      warnings.push_back(
          fmt::format("body.{}: the mesh has no texture coordinates; look.texture is not used", description.name));
    return nullptr;
  }
  if (!chosen && !std::filesystem::exists(path, error)) {
    warnings.push_back(fmt::format("body.{}: the mesh names the texture {}, which is not there; drawn without it",
                                   description.name, path.string()));
    return nullptr;
  }
  return std::make_shared<const Image>(read_image(path));
}

BodySetup cage_body(const BodyDescription& description, const std::vector<Obstacle>& obstacles) {
  BodySetup setup{.name = description.name,
                  .shape = place_body(description),
                  .lattice = {},
                  .cage = {},
                  .embedding = {},
                  .texture = {}};
  named("body." + description.name, [&] {
    if (description.drop_height) apply_drop_height(*description.drop_height, obstacles, setup.shape);
    const PlacedMesh& shape = setup.shape;
    setup.lattice = shape.hexes ? make_hex_cage(shape.mesh, shape.hexes->mesh.nodes, shape.hexes->mesh.hexes,
                                                {.is_the_body = shape.hexes->are_the_body()}, &setup.cage)
                                : voxelize(shape.mesh, cage_options(description.cage), &setup.cage);
    setup.embedding = embed(setup.shape.mesh, setup.lattice);
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
  body.velocity = description.velocity;
  body.spin = description.spin_degrees * (EIGEN_PI / 180);
  body.fixed_nodes =
      named("body." + description.name, [&] { return nodes_in_boxes(description.fixed, setup.lattice); });
  if (setup.shape.hexes) {
    body.young_factor = setup.shape.hexes->mesh.young_factor;
    body.limit_factor = setup.shape.hexes->mesh.limit_factor;
  }
  body.surface = setup.embedding.points;
  body.surface_rest = setup.shape.mesh.positions;
  if (needs_distance)
    body.rest_distance = std::make_shared<const SampledDistance>(make_distance_grid(setup.shape.mesh));
  return body;
}

bool has_edges(const Obstacle& obstacle) {
  return std::holds_alternative<Block>(obstacle.shape) || std::holds_alternative<MeshShape>(obstacle.shape);
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
      const Pose pose = pose_at(obstacle, 0);
      double deepest = 0;
      for (const auto& point : body.shape.mesh.positions.rowwise())
        deepest = std::min(deepest, signed_distance(obstacle.shape, pose.local(point.transpose())).distance);
      if (deepest < -1e-6)
        warnings.push_back(
            fmt::format("body.{} starts {:.4g} m deep inside obstacle.{} and will be pushed out slowly; raise its "
                        "position to avoid it",
                        body.name, -deepest, obstacle.name));
    }
}

}  // namespace

PlacedMesh place_body(const BodyDescription& body) {
  return named("body." + body.name, [&] {
    Placement placement{.unit = {},
                        .up = {},
                        .height = body.height,
                        .scale = body.scale,
                        .rotation_degrees = body.rotation_degrees,
                        .position = body.position};
    PlacedMesh shape = std::visit([&](const auto& source) { return read_shape(source, placement); }, body.source);
    if (const auto* cage = std::get_if<MeshSource>(&body.cage.size)) read_cage_mesh(*cage, shape);
    shape.world_from_file = place(shape.mesh, placement, shape.hexes ? &shape.hexes->mesh.nodes : nullptr);
    tie_to_nodes(shape);
    if (shape.mesh.normals.rows() == 0) compute_normals(shape.mesh);
    return shape;
  });
}

CageOptions cage_options(const CageDescription& cage) {
  CageOptions options{.whole_box = cage.clip == CageDescription::Clip::box};
  if (const int* count = std::get_if<int>(&cage.size)) options.size = *count;
  if (const Vector3i* grid = std::get_if<Vector3i>(&cage.size)) options.size = *grid;
  if (const double* edge = std::get_if<double>(&cage.size)) options.size = *edge;
  return options;
}

Obstacle make_obstacle(const ObstacleDescription& description, ObstacleSetup& setup) {
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
  } else {
    named("obstacle." + description.name, [&] {
      Placement placement{
          .unit = {}, .up = {}, .height = description.height, .scale = description.scale, .position = {}};
      TriangleMesh mesh = read_shape(std::get<MeshSource>(description.shape), placement).mesh;
      place(mesh, placement);
      compute_normals(mesh);
      const double extent = (highest(mesh) - lowest(mesh)).maxCoeff();
      MeshShape shape;
      shape.distance = std::make_shared<const SampledDistance>(make_distance_grid(mesh));
      shape.edge_points = sharp_edge_points(mesh, {.spacing = extent / 100});
      obstacle.shape = std::move(shape);
      setup.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
      return 0;
    });
  }
  return obstacle;
}

Simulation set_up(const Scene& scene, const CageWatch& watch) {
  Simulation simulation;
  simulation.scene = scene;
  simulation.options.time_step = scene.clip.time_step();
  simulation.options.gravity = scene.clip.gravity;
  simulation.options.solver = scene.solver;

  std::vector<Obstacle> obstacles;
  for (const ObstacleDescription& description : scene.obstacles)
    obstacles.push_back(make_obstacle(description, simulation.obstacles.emplace_back()));

  const bool needs_distance = std::any_of(obstacles.begin(), obstacles.end(), has_edges);
  std::vector<Body> bodies;
  for (const BodyDescription& description : scene.bodies) {
    BodySetup& setup = simulation.bodies.emplace_back(cage_body(description, obstacles));
    if (watch) watch(simulation.bodies);
    for (const std::string& note : setup.shape.notes) simulation.warnings.push_back("body." + setup.name + ": " + note);
    for (const std::string& note : setup.cage.notes) simulation.warnings.push_back("body." + setup.name + ": " + note);
    setup.texture = read_texture(description, setup.shape, simulation.warnings);
    bodies.push_back(make_body(description, setup, needs_distance));
    apply_maps(description, setup, bodies.back(), simulation.warnings);
  }
  simulation.model = make_model(bodies, obstacles);
  require_measurable(simulation.model, scene.solver.energy);
  require_solvable(plan_linear_solvers(simulation.model, scene.solver), scene.solver);
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i) {
    simulation.bodies[i].first_node = simulation.model.bodies[i].first_node;
    simulation.bodies[i].first_hex = simulation.model.bodies[i].first_hex;
  }
  simulation.probes = embed_probes(scene, simulation.bodies);
  simulation.digest = model_digest(simulation.model, simulation.options);
  warn_of_penetration(simulation, simulation.warnings);
  warn_of_sudden_limits(simulation, simulation.warnings);
  return simulation;
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
