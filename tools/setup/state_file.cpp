#include "tools/setup/state_file.h"

#include <bit>
#include <cstring>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "core/model/deformation.h"
#include "core/model/pins.h"

namespace umax {
namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

constexpr std::string_view magic = "UMAXSTAT";
constexpr std::uint32_t version = 4;
constexpr std::size_t digest_size = 64, header_size = 8 + 4 + 4 + digest_size;

// Structures are taken apart by structured bindings with all their members: one that is added and forgotten here does
// not compile.

/// Values one after another, as the bytes that they have in memory: to be kept, or for their digest alone.
class Writer {
 public:
  explicit Writer(Sha256* digest = nullptr) : digest_(digest) {}

  template <class T>
  void put(T value) {
    put_bytes(&value, sizeof value);
  }
  template <class... T>
  void put_all(T... values) {
    (put(values), ...);
  }
  void put_bytes(const void* values, std::size_t count) {
    const auto* start = static_cast<const char*>(values);
    if (digest_)
      digest_->add({start, count});
    else
      bytes.append(start, count);
  }
  /// Number of rows, then the values.
  template <class Matrix>
  void put_matrix(const Matrix& matrix) {
    put(std::uint64_t(matrix.rows()));
    put_bytes(matrix.data(), std::size_t(matrix.size()) * sizeof(typename Matrix::Scalar));
  }
  std::string bytes;

 private:
  Sha256* digest_ = nullptr;
};

// ---- model digest ----

void add_value(Writer& out, double value) {
  out.put(value);
}
void add_value(Writer& out, const Vector3d& value) {
  out.put_matrix(value);
}

template <class T>
void add_track(Writer& out, const Track<T>& track) {
  out.put(std::uint64_t(track.times.size()));
  for (const double time : track.times) out.put(time);
  for (const T& value : track.values) add_value(out, value);
  out.put(track.interpolation);
}

void add_distance(Writer& out, const SampledDistance* distance) {
  out.put(std::uint8_t(distance != nullptr));
  if (distance == nullptr) return;
  out.put_matrix(distance->origin);
  out.put(distance->spacing);
  out.put_matrix(distance->size);
  out.put_bytes(distance->values.data(), distance->values.size() * sizeof(float));
}

void add_shape(Writer& out, const HalfSpace&) {
  out.put(std::uint8_t(0));
}
void add_shape(Writer& out, const Ball& ball) {
  out.put(ball.radius);
}
void add_shape(Writer& out, const Block& block) {
  out.put_matrix(block.half_size);
}
void add_shape(Writer& out, const MeshShape& mesh) {
  add_distance(out, mesh.distance.get());
  out.put_matrix(mesh.edge_points);
}
void add_shape(Writer& out, const TriangleShape& shape) {
  const auto& [surface, thickness, is_closed, edge_points] = shape;
  out.put_matrix(surface->vertices);
  out.put_matrix(surface->triangles);
  out.put_all(thickness, is_closed, std::uint8_t(edge_points != nullptr));
  if (!edge_points) return;
  out.put_matrix(edge_points->from);
  out.put_matrix(edge_points->to);
  out.put_matrix(edge_points->share);
}

void add_motion(Writer& out, const MeshMotion& motion) {
  const auto& [times, samples, num_vertices, placed_from_own] = motion;
  out.put(std::uint64_t(times.size()));
  out.put_bytes(times.data(), times.size() * sizeof(double));
  out.put_bytes(samples.data(), samples.size() * sizeof(float));
  out.put(std::int64_t(num_vertices));
  out.put_matrix(placed_from_own.matrix());
}

void add_material(Writer& out, const MaterialOptions& material) {
  const auto& [young, poisson, density, mass, damping_mass, damping_stiffness] = material;
  add_track(out, young);
  out.put_all(poisson, density, mass, damping_mass, damping_stiffness);
}

void add_limit(Writer& out, const EnergyLimitOptions& limit) {
  const auto& [kind, unit, value, measure] = limit;
  out.put_all(kind, unit, measure);
  add_track(out, value);
}

void add_part_limits(Writer& out, const PartLimitOptions& limits) {
  const auto& [volumetric, deviatoric, fibre, fibre_direction] = limits;
  static_cast<void>(fibre_direction);  // in the model's fibre directions
  for (const EnergyLimitOptions* limit : {&volumetric, &deviatoric, &fibre}) add_limit(out, *limit);
}

void add_pin(Writer& out, const Pin& pin) {
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

void add_body(Writer& out, const Model::BodyRange& body) {
  const auto& [name, first_node, num_nodes, first_hex, num_hexes, first_point, num_points, material, limit, part_limits,
               friction, contact, cell_size, cells, cell_edges, rest_distance, rest_surface, rest_pose, pins] = body;
  static_cast<void>(cells);  // they and cell_edges follow from the nodes and hexes
  static_cast<void>(cell_edges);
  out.put_bytes(name.data(), name.size());
  out.put_all(first_node, num_nodes, first_hex, num_hexes, first_point, num_points);
  add_material(out, material);
  add_limit(out, limit);
  add_part_limits(out, part_limits);
  out.put_all(friction, contact, cell_size);
  add_distance(out, rest_distance.get());
  if (pins)
    for (const Pin& pin : pins->pins()) add_pin(out, pin);
  out.put(std::uint8_t(rest_surface != nullptr));
  if (!rest_surface) return;
  out.put_matrix(rest_surface->vertices);
  out.put_matrix(rest_surface->triangles);
  out.put_matrix(rest_pose.rotation);
  out.put_matrix(rest_pose.translation);
}

void add_pair(Writer& out, const BodyPair& pair) {
  const auto& [a, b, touch, friction] = pair;
  out.put_all(a, b, touch, std::uint8_t(friction.has_value()), friction.value_or(0));
}

void add_obstacle(Writer& out, const Obstacle& obstacle) {
  const auto& [name, shape, friction, position, rotation_degrees, deformation] = obstacle;
  out.put_bytes(name.data(), name.size());
  out.put(std::uint64_t(shape.index()));
  std::visit([&out](const auto& kind) { add_shape(out, kind); }, shape);
  out.put(friction);
  add_track(out, position);
  add_track(out, rotation_degrees);
  if (deformation) add_motion(out, deformation->motion());
}

void add_options(Writer& out, const StepOptions& options) {
  const auto& [time_step, gravity, solver, on_iteration] = options;
  static_cast<void>(on_iteration);  // watches, changes nothing
  out.put(time_step);
  out.put_matrix(gravity);
  const auto& [method, linear, tolerance, energy, rotation, jacobian, max_iterations, max_newton_iterations,
               max_augmented_iterations, max_halvings, max_sweeps, sweep_tolerance] = solver;
  out.put_all(method, linear, tolerance, energy, rotation, jacobian, max_iterations, max_newton_iterations,
              max_augmented_iterations, max_halvings, max_sweeps, sweep_tolerance);
}

// ---- reading ----

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& where) : rest_(bytes), where_(where) {}

  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    throw Error(Fault::bad_data, {where_, what, "", remedy});
  }
  std::string_view take(std::size_t count) {
    if (count > rest_.size())
      fail("is damaged: it ends too early", "delete it; --resume goes on from the state before");
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  template <class T>
  T get() {
    T value;
    const std::string_view bytes = take(sizeof value);
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  std::size_t get_count(std::size_t bytes_each) {
    const auto count = get<std::uint64_t>();
    if (count > rest_.size() / bytes_each) take(rest_.size() + 1);
    return std::size_t(count);
  }
  Points get_points() {
    Points points(Eigen::Index(get_count(3 * sizeof(double))), 3);
    const std::size_t size = std::size_t(points.size()) * sizeof(double);
    if (size > 0) std::memcpy(points.data(), take(size).data(), size);
    return points;
  }
  VectorXd get_vector() {
    VectorXd vector(Eigen::Index(get_count(sizeof(double))));
    const std::size_t size = std::size_t(vector.size()) * sizeof(double);
    if (size > 0) std::memcpy(vector.data(), take(size).data(), size);
    return vector;
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
  const std::string& where_;
};

/// Checks magic, version and checksum; gives back the reader behind the header.
Reader open_state(std::string_view bytes, const std::string& where, Digest& model) {
  Reader reader(bytes, where);
  if (bytes.size() < magic.size() || bytes.substr(0, magic.size()) != magic)
    reader.fail("is not a state file", "give a folder that umax simulate made");
  if (bytes.size() < header_size + digest_size) reader.take(bytes.size() + 1);
  reader.take(magic.size());
  const auto found_version = reader.get<std::uint32_t>();
  if (found_version != version)
    reader.fail("was written by another version of umax (state format " + std::to_string(found_version) + ")",
                "simulate again with --overwrite");
  reader.get<std::uint32_t>();
  model = reader.take(digest_size);

  const std::size_t body_size = bytes.size() - digest_size;
  if (sha256_hex(bytes.substr(0, body_size)) != bytes.substr(body_size))
    reader.fail("is damaged: its checksum does not fit", "delete it; --resume goes on from the state before");
  return Reader(bytes.substr(header_size, body_size - header_size), where);
}

// Edge points of obstacles have the numbers below zero.
std::int32_t number_of(const ContactPoint& point) {
  return point.kind == ContactKind::obstacle_edge ? -1 - point.index : point.index;
}
ContactPoint point_of(std::int32_t number, int obstacle) {
  if (number < 0) return {ContactKind::obstacle_edge, -1 - number};
  return {obstacle < 0 ? ContactKind::surface : ContactKind::vertex, number};
}

}  // namespace

Digest model_digest(const Model& model, const StepOptions& options) {
  const auto& [bodies, pairs, obstacles, rest_positions, initial_velocities, node_mass, node_fixed, hexes, corners,
               corner_starts, shapes, hex_shape, hex_body, young_factor, limit_factor, fibre_directions, limits,
               limit_starts, limit_forms, surface] = model;
  static_cast<void>(corners);  // these two from the hexes
  static_cast<void>(corner_starts);
  static_cast<void>(shapes);  // follow from the rest positions and the materials
  static_cast<void>(limits);  // these three from the bodies' limits and the fibre directions
  static_cast<void>(limit_starts);
  static_cast<void>(limit_forms);
  Sha256 digest;
  Writer out(&digest);
  out.put(version);
  for (const auto& body : bodies) add_body(out, body);
  for (const auto& pair : pairs) add_pair(out, pair);
  for (const auto& obstacle : obstacles) add_obstacle(out, obstacle);
  out.put_matrix(rest_positions);
  out.put_matrix(initial_velocities);
  out.put_matrix(node_mass);
  out.put_bytes(node_fixed.data(), node_fixed.size());
  out.put_matrix(hexes);
  out.put_matrix(hex_shape);
  out.put_matrix(hex_body);
  out.put_matrix(young_factor);
  out.put_matrix(limit_factor);
  out.put_matrix(fibre_directions);
  out.put_matrix(surface.hex);
  out.put_matrix(surface.weights);
  add_options(out, options);
  return digest.hex();
}

std::string encode_state(const State& state, const Digest& model) {
  const auto& [time, step, been_feasible, positions, velocities, limit_multipliers, contacts] = state;
  Writer writer;
  writer.bytes.append(magic);
  writer.put_all(version, std::uint32_t(0));
  writer.bytes.append(model);
  writer.put_all(time, std::int64_t(step), std::uint64_t(been_feasible));
  writer.put_matrix(positions);
  writer.put_matrix(velocities);
  writer.put_matrix(limit_multipliers);
  writer.put(std::uint64_t(contacts.size()));
  for (const auto& contact : contacts) {
    const auto& [point, obstacle, hex, other_hex, impulse] = contact;
    writer.put_all(number_of(point), std::int32_t(obstacle), std::int32_t(hex), std::int32_t(other_hex));
    writer.put_all(impulse.x(), impulse.y(), impulse.z());
  }
  writer.bytes.append(sha256_hex(writer.bytes));
  return std::move(writer.bytes);
}

State decode_state(std::string_view bytes, const std::string& where, Digest& model) {
  Reader reader = open_state(bytes, where, model);
  State state;
  state.time = reader.get<double>();
  state.step = reader.get<std::int64_t>();
  state.been_feasible = reader.get<std::uint64_t>() != 0;
  state.positions = reader.get_points();
  state.velocities = reader.get_points();
  state.limit_multipliers = reader.get_vector();
  state.contacts.resize(reader.get_count(4 * sizeof(std::int32_t) + 3 * sizeof(double)));
  for (auto& contact : state.contacts) {
    const auto number = reader.get<std::int32_t>();
    contact.obstacle = reader.get<std::int32_t>();
    contact.point = point_of(number, contact.obstacle);
    contact.hex = reader.get<std::int32_t>();
    contact.other_hex = reader.get<std::int32_t>();
    for (int axis = 0; axis < 3; ++axis) contact.impulse[axis] = reader.get<double>();
  }
  if (!reader.at_end())
    reader.fail("is damaged: it goes on after its end", "delete it and simulate again with --resume");
  return state;
}

void write_state(const std::filesystem::path& path, const State& state, const Digest& model) {
  write_file(path, encode_state(state, model));
}

void require_state_of(const Model& model, const Digest& digest, const std::filesystem::path& path, const State& state,
                      const Digest& made_with) {
  if (made_with != digest)
    throw Error(Fault::bad_data, {.where = path.string(),
                                  .what = "was made by another scene, mesh or solver setting",
                                  .remedy = "give the run another folder with -o, or replace it with --overwrite"});
  if (state.positions.rows() != model.num_nodes() || state.velocities.rows() != model.num_nodes() ||
      state.limit_multipliers.size() != Eigen::Index(model.limits.size()))
    throw Error(Fault::bad_data, {.where = path.string(),
                                  .what = "has other sizes than its model",
                                  .remedy = "simulate again with --overwrite"});
}

State read_state(const std::filesystem::path& path, const Model& model, const Digest& digest) {
  Digest made_with;
  State state = decode_state(read_file(path), path.string(), made_with);
  require_state_of(model, digest, path, state, made_with);
  return state;
}

}  // namespace umax
