#include "tools/setup/model_digest.h"

#include "core/model/deformation.h"
#include "core/model/pins.h"
#include "tools/setup/byte_writer.h"

// Structures are taken apart by structured bindings with all their members: one that is added and forgotten here does
// not compile.

namespace umax {
namespace {

void add_value(ByteWriter& out, double value) {
  out.put(value);
}
void add_value(ByteWriter& out, const Vector3d& value) {
  out.put_matrix(value);
}

template <class T>
void add_track(ByteWriter& out, const Track<T>& track) {
  out.put(std::uint64_t(track.times.size()));
  for (const double time : track.times) out.put(time);
  for (const T& value : track.values) add_value(out, value);
  out.put(track.interpolation);
}

/// A constant is its value alone, as it was before it could have keys.
void add_constant_or_track(ByteWriter& out, const Track<double>& track) {
  if (track.is_constant())
    out.put(track.values.front());
  else
    add_track(out, track);
}

void add_distance(ByteWriter& out, const SampledDistance* distance) {
  out.put(std::uint8_t(distance != nullptr));
  if (distance == nullptr) return;
  out.put_matrix(distance->origin);
  out.put(distance->spacing);
  out.put_matrix(distance->size);
  out.put_bytes(distance->values.data(), distance->values.size() * sizeof(float));
}

void add_shape(ByteWriter& out, const HalfSpace&) {
  out.put(std::uint8_t(0));
}
void add_shape(ByteWriter& out, const Ball& ball) {
  out.put(ball.radius);
}
void add_shape(ByteWriter& out, const Block& block) {
  out.put_matrix(block.half_size);
}
void add_shape(ByteWriter& out, const MeshShape& mesh) {
  add_distance(out, mesh.distance.get());
  out.put_matrix(mesh.edge_points);
}
void add_shape(ByteWriter& out, const TriangleShape& shape) {
  const auto& [surface, thickness, is_closed, edge_points] = shape;
  out.put_matrix(surface->vertices);
  out.put_matrix(surface->triangles);
  out.put_all(thickness, is_closed, std::uint8_t(edge_points != nullptr));
  if (!edge_points) return;
  out.put_matrix(edge_points->from);
  out.put_matrix(edge_points->to);
  out.put_matrix(edge_points->share);
}

void add_motion(ByteWriter& out, const MeshMotion& motion) {
  const auto& [times, samples, num_vertices, placed_from_own] = motion;
  out.put(std::uint64_t(times.size()));
  out.put_bytes(times.data(), times.size() * sizeof(double));
  out.put_bytes(samples.data(), samples.size() * sizeof(float));
  out.put(std::int64_t(num_vertices));
  out.put_matrix(placed_from_own.matrix());
}

void add_material(ByteWriter& out, const MaterialOptions& material) {
  const auto& [young, poisson, density, mass, damping_mass, damping_stiffness] = material;
  add_track(out, young);
  out.put(poisson);
  add_constant_or_track(out, density);
  out.put(mass);
  add_constant_or_track(out, damping_mass);
  add_constant_or_track(out, damping_stiffness);
}

void add_limit(ByteWriter& out, const EnergyLimitOptions& limit) {
  const auto& [kind, unit, value, measure] = limit;
  out.put_all(kind, unit, measure);
  add_track(out, value);
}

void add_part_limits(ByteWriter& out, const PartLimitOptions& limits) {
  const auto& [volumetric, deviatoric, fibre, fibre_direction] = limits;
  static_cast<void>(fibre_direction);  // in the model's fibre directions
  for (const EnergyLimitOptions* limit : {&volumetric, &deviatoric, &fibre}) add_limit(out, *limit);
}

void add_pin(ByteWriter& out, const Pin& pin) {
  const auto& [name, points, rest, part, stiffness, motion, from, until] = pin;
  const auto& [position, rotation_degrees, pivot, mesh, corners, shares, preroll] = motion;
  out.put_bytes(name.data(), name.size());
  out.put_matrix(points.hex);
  out.put_matrix(points.weights);
  out.put_matrix(rest);
  out.put_matrix(part);
  out.put_matrix(stiffness);
  add_track(out, position);
  add_track(out, rotation_degrees);
  out.put_matrix(pivot);
  out.put(std::uint8_t(mesh != nullptr));
  if (mesh) add_motion(out, *mesh);
  out.put_matrix(corners);
  out.put_matrix(shares);
  out.put_all(preroll, from, until);
}

void add_body(ByteWriter& out, const Model::BodyRange& body) {
  const auto& [name, first_node, num_nodes, first_hex, num_hexes, first_point, num_points, material, limit, part_limits,
               friction, friction_keys, contact, cell_size, cells, cell_edges, rest_distance, rest_surface, rest_scale,
               rest_pose, pins, surface] = body;
  static_cast<void>(surface);   // of all bodies: add_surfaces()
  static_cast<void>(friction);  // of friction_keys
  static_cast<void>(cells);     // they and cell_edges follow from the nodes and hexes
  static_cast<void>(cell_edges);
  out.put_bytes(name.data(), name.size());
  out.put_all(first_node, num_nodes, first_hex, num_hexes, first_point, num_points);
  add_material(out, material);
  add_limit(out, limit);
  add_part_limits(out, part_limits);
  add_constant_or_track(out, friction_keys);
  out.put_all(contact, cell_size);
  add_distance(out, rest_distance.get());
  if (pins)
    for (const Pin& pin : pins->pins()) add_pin(out, pin);
  out.put(std::uint8_t(rest_surface != nullptr));
  if (!rest_surface) return;
  out.put_matrix(rest_surface->vertices);
  out.put_matrix(rest_surface->triangles);
  if (rest_scale != 1) out.put_all(rest_scale);
  out.put_matrix(rest_pose.rotation);
  out.put_matrix(rest_pose.translation);
}

// The points of all bodies as one list, with the model's hexes.
void add_surfaces(ByteWriter& out, const Model& model) {
  out.put(std::uint64_t(model.num_points()));
  for (const auto& body : model.bodies) {
    const VectorXi hex = body.surface->hex.array() + body.first_hex;
    out.put_bytes(hex.data(), std::size_t(hex.size()) * sizeof(int));
  }
  out.put(std::uint64_t(model.num_points()));
  for (const auto& body : model.bodies)
    out.put_bytes(body.surface->weights.data(), std::size_t(body.surface->weights.size()) * sizeof(double));
}

void add_pair(ByteWriter& out, const BodyPair& pair) {
  const auto& [a, b, touch, friction] = pair;
  out.put_all(a, b, touch, std::uint8_t(friction.has_value()), friction.value_or(0));
}

void add_obstacle(ByteWriter& out, const Obstacle& obstacle) {
  const auto& [name, shape, friction, position, rotation_degrees, deformation] = obstacle;
  out.put_bytes(name.data(), name.size());
  out.put(std::uint64_t(shape.index()));
  std::visit([&out](const auto& kind) { add_shape(out, kind); }, shape);
  out.put(friction);
  add_track(out, position);
  add_track(out, rotation_degrees);
  if (deformation) add_motion(out, deformation->motion());
}

void add_options(ByteWriter& out, const StepOptions& options) {
  const auto& [time_step, gravity, solver, pulls, forces, on_iteration] = options;
  static_cast<void>(pulls);         // of one step
  static_cast<void>(forces);        // likewise
  static_cast<void>(on_iteration);  // watches, changes nothing
  out.put(time_step);
  out.put_matrix(gravity);
  const auto& [method, linear, tolerance, energy, rotation, jacobian, max_iterations, max_newton_iterations,
               max_augmented_iterations, max_halvings, max_sweeps, sweep_tolerance] = solver;
  out.put_all(method, linear, tolerance, energy, rotation, jacobian, max_iterations, max_newton_iterations,
              max_augmented_iterations, max_halvings, max_sweeps, sweep_tolerance);
}

}  // namespace

Digest with_gravity_keys(const Digest& digest, const Track<Vector3d>& gravity) {
  if (gravity.is_constant()) return digest;
  Sha256 sum;
  ByteWriter out(&sum);
  out.put_bytes(digest.data(), digest.size());
  add_track(out, gravity);
  return sum.hex();
}

Digest model_digest(const Model& model, const StepOptions& options) {
  const auto& [bodies, pairs, obstacles, rest_positions, initial_velocities, node_mass, node_mass_t0, node_fixed, hexes,
               corners, corner_starts, shapes, hex_shape, hex_body, young_factor, limit_factor, fibre_directions,
               limits, limit_starts, limit_forms] = model;
  static_cast<void>(corners);  // these two from the hexes
  static_cast<void>(corner_starts);
  static_cast<void>(shapes);  // follow from the rest positions and the materials
  static_cast<void>(limits);  // these three from the bodies' limits and the fibre directions
  static_cast<void>(limit_starts);
  static_cast<void>(limit_forms);
  Sha256 digest;
  ByteWriter out(&digest);
  out.put(state_format);
  for (const auto& body : bodies) add_body(out, body);
  for (const auto& pair : pairs) add_pair(out, pair);
  for (const auto& obstacle : obstacles) add_obstacle(out, obstacle);
  out.put_matrix(rest_positions);
  out.put_matrix(initial_velocities);
  static_cast<void>(node_mass);  // of node_mass_t0 and densities
  out.put_matrix(node_mass_t0);
  out.put_bytes(node_fixed.data(), node_fixed.size());
  out.put_matrix(hexes);
  out.put_matrix(hex_shape);
  out.put_matrix(hex_body);
  out.put_matrix(young_factor);
  out.put_matrix(limit_factor);
  out.put_matrix(fibre_directions);
  add_surfaces(out, model);
  add_options(out, options);
  return digest.hex();
}

}  // namespace umax
