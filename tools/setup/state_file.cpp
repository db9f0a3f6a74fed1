#include "tools/setup/state_file.h"

#include <bit>
#include <cstring>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "tools/setup/byte_writer.h"

namespace umax {
namespace {

static_assert(std::endian::native == std::endian::little, "state files are little-endian");

constexpr std::string_view magic = "UMAXSTAT";
constexpr std::size_t digest_size = 64, header_size = 8 + 4 + 4 + digest_size;

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
  if (found_version != state_format)
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

std::string encode_state(const State& state, const Digest& model) {
  const auto& [time, step, been_feasible, positions, velocities, limit_multipliers, contacts] = state;
  ByteWriter writer;
  writer.bytes.append(magic);
  writer.put_all(state_format, std::uint32_t(0));
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
