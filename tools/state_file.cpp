#include "tools/state_file.h"

#include <bit>
#include <cstring>

#include "core/error.h"
#include "render/write_file.h"
#include "scenes/sha256.h"

namespace umax {
namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

constexpr std::string_view magic = "UMAXSTAT";
constexpr std::uint32_t version = 1;
constexpr std::size_t digest_size = 64, header_size = 8 + 4 + 4 + digest_size;

/// Values one after another, as the bytes that they have in memory.
class Writer {
 public:
  template <class T>
  void put(T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put_bytes(const void* values, std::size_t count) { bytes.append(static_cast<const char*>(values), count); }
  /// Number of rows, then the values.
  template <class Matrix>
  void put_matrix(const Matrix& matrix) {
    put(std::uint64_t(matrix.rows()));
    put_bytes(matrix.data(), std::size_t(matrix.size()) * sizeof(typename Matrix::Scalar));
  }
  std::string bytes;
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

void add_body(Writer& out, const Model::BodyRange& body) {
  for (const int number :
       {body.first_node, body.num_nodes, body.first_hex, body.num_hexes, body.first_point, body.num_points})
    out.put(number);
  add_track(out, body.material.young);
  for (const double value : {body.material.poisson, body.material.density, body.material.damping_mass,
                             body.material.damping_stiffness, body.friction})
    out.put(value);
  out.put(body.material.mass);
  out.put(body.limit.kind);
  out.put(body.limit.unit);
  add_track(out, body.limit.value);
  add_distance(out, body.rest_distance.get());
}

void add_obstacle(Writer& out, const Obstacle& obstacle) {
  out.put(std::uint64_t(obstacle.shape.index()));
  std::visit([&](const auto& shape) { add_shape(out, shape); }, obstacle.shape);
  out.put(obstacle.friction);
  add_track(out, obstacle.position);
  add_track(out, obstacle.rotation_degrees);
}

// ---- reading ----

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& where) : rest_(bytes), where_(where) {}

  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    throw Error(ExitCode::bad_data, {where_, what, "", remedy});
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
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
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

}  // namespace

Digest model_digest(const Model& model, const StepOptions& options) {
  Writer out;
  out.put(version);
  for (const auto& body : model.bodies) add_body(out, body);
  for (const auto& obstacle : model.obstacles) add_obstacle(out, obstacle);
  out.put_matrix(model.rest_positions);
  out.put_matrix(model.initial_velocities);
  out.put_matrix(model.node_mass);
  out.put_bytes(model.node_fixed.data(), model.node_fixed.size());
  out.put_matrix(model.hexes);
  out.put_matrix(model.hex_shape);
  out.put_matrix(model.hex_body);
  out.put_matrix(model.young_factor);
  out.put_matrix(model.limit_factor);
  out.put_matrix(model.surface.hex);
  out.put_matrix(model.surface.weights);

  out.put(options.time_step);
  out.put_matrix(options.gravity);
  const SolverOptions& solver = options.solver;
  out.put(solver.method);
  out.put(solver.tolerance);
  out.put(solver.energy);
  out.put(solver.rotation);
  out.put(solver.jacobian);
  out.put(solver.max_iterations);
  out.put(solver.max_sweeps);
  out.put(solver.sweep_tolerance);
  return sha256_hex(out.bytes);
}

std::string encode_state(const State& state, const Digest& model) {
  Writer writer;
  writer.bytes.append(magic);
  writer.put(version);
  writer.put(std::uint32_t(0));
  writer.bytes.append(model);

  writer.put(state.time);
  writer.put(std::int64_t(state.step));
  writer.put(state.substep);
  writer.put(std::uint64_t(state.been_feasible));
  writer.put_matrix(state.positions);
  writer.put_matrix(state.velocities);
  writer.put_matrix(state.limit_multipliers);
  writer.put(std::uint64_t(state.contacts.size()));
  for (const auto& contact : state.contacts) {
    writer.put(std::int32_t(contact.point));
    writer.put(std::int32_t(contact.obstacle));
    for (int axis = 0; axis < 3; ++axis) writer.put(contact.impulse[axis]);
  }

  writer.bytes.append(sha256_hex(writer.bytes));
  return std::move(writer.bytes);
}

State decode_state(std::string_view bytes, const std::string& where, Digest& model) {
  Reader reader = open_state(bytes, where, model);
  State state;
  state.time = reader.get<double>();
  state.step = reader.get<std::int64_t>();
  state.substep = reader.get<double>();
  state.been_feasible = reader.get<std::uint64_t>() != 0;
  state.positions = reader.get_points();
  state.velocities = reader.get_points();
  state.limit_multipliers = reader.get_vector();
  state.contacts.resize(reader.get_count(2 * sizeof(std::int32_t) + 3 * sizeof(double)));
  for (auto& contact : state.contacts) {
    contact.point = reader.get<std::int32_t>();
    contact.obstacle = reader.get<std::int32_t>();
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
    throw Error(ExitCode::bad_data, {.where = path.string(),
                                     .what = "was made by another scene, mesh or solver setting",
                                     .remedy = "give the run another folder with -o, or replace it with --overwrite"});
  if (state.positions.rows() != model.num_nodes() || state.velocities.rows() != model.num_nodes() ||
      state.limit_multipliers.size() != model.num_hexes())
    throw Error(ExitCode::bad_data, {.where = path.string(),
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
