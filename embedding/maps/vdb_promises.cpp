#include "embedding/maps/vdb_promises.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace umax {
namespace {

constexpr std::int64_t magic = 0x56444220;
constexpr std::uint32_t oldest_format = 222, newest_format = 224;
constexpr std::uint32_t with_zip = 1, with_active_mask = 2, with_blosc = 4;  // bits of a grid's compression
constexpr std::int64_t no_size = -1;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what);
}

/// The file's numbers, never read from beyond its end.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& path)
      : in_(path, std::ios::binary), size_(std::int64_t(std::filesystem::file_size(path))) {}

  std::int64_t at() const { return at_; }
  std::int64_t size() const { return size_; }

  void go_to(std::int64_t position) {
    require(position >= 0 && position <= size_, fmt::format("it points to byte {} of {}", position, size_));
    at_ = position;
    in_.seekg(position);
  }
  void skip(std::int64_t count) {
    require(count >= 0 && count <= size_ - at_, fmt::format("it ends within {} bytes at byte {}", count, at_));
    go_to(at_ + count);
  }
  template <class Number>
  Number number() {
    Number value{};
    read(&value, sizeof value);
    return value;
  }
  std::string string() {
    const auto length = number<std::uint32_t>();
    require(length <= size_ - at_, fmt::format("a text of {} bytes at byte {}", length, at_));
    std::string text(length, '\0');
    read(text.data(), length);
    return text;
  }
  /// The next bits as words of 64.
  std::vector<std::uint64_t> mask(int num_bits) {
    std::vector<std::uint64_t> words(std::size_t(num_bits) / 64);
    read(words.data(), num_bits / 8);
    return words;
  }

 private:
  void read(void* target, std::int64_t count) {
    require(count <= size_ - at_, fmt::format("it ends within {} bytes at byte {}", count, at_));
    in_.read(static_cast<char*>(target), count);
    require(in_.good(), "it cannot be read");
    at_ += count;
  }

  std::ifstream in_;
  std::int64_t size_ = 0, at_ = 0;
};

int num_on(const std::vector<std::uint64_t>& mask) {
  int count = 0;
  for (const std::uint64_t word : mask) count += std::popcount(word);
  return count;
}

/// The types of metadata that OpenVDB reads by the type and not by the stored size.
std::int64_t metadata_size(const std::string& type) {
  static const std::map<std::string, std::int64_t> sizes{{"bool", 1},   {"int32", 4},  {"int64", 8},  {"float", 4},
                                                         {"double", 8}, {"vec2i", 8},  {"vec2s", 8},  {"vec2d", 16},
                                                         {"vec3i", 12}, {"vec3s", 12}, {"vec3d", 24}, {"vec4i", 16},
                                                         {"vec4s", 16}, {"vec4d", 32}, {"mat4s", 64}, {"mat4d", 128}};
  const auto found = sizes.find(type);
  return found != sizes.end() ? found->second : no_size;
}

/// Returns whether it says that floats are stored as halves, which OpenVDB believes here and not in a grid's type.
bool walk_metadata(Bytes& bytes) {
  bool as_halves = false;
  for (auto left = bytes.number<std::uint32_t>(); left > 0; --left) {
    const std::string name = bytes.string(), type = bytes.string();
    const std::int64_t size = bytes.number<std::uint32_t>(), expected = metadata_size(type);
    require(expected == no_size || expected == size, fmt::format("metadata of {} bytes at byte {}", size, bytes.at()));
    if (name != "is_saved_as_half_float") {
      bytes.skip(size);
      continue;
    }
    require(type == "bool", "whether numbers are stored as halves is not clear");
    as_halves = bytes.number<char>() != 0;
  }
  return as_halves;
}

void walk_transform(Bytes& bytes) {
  constexpr int number = 8;
  static const std::map<std::string, int> num_numbers{{"AffineMap", 16},
                                                      {"UnitaryMap", 16},
                                                      {"ScaleMap", 15},
                                                      {"UniformScaleMap", 15},
                                                      {"TranslationMap", 3},
                                                      {"ScaleTranslateMap", 18},
                                                      {"UniformScaleTranslateMap", 18}};
  std::string type = bytes.string();
  if (type == "NonlinearFrustumMap") {
    bytes.skip(8 * number);
    type = bytes.string();
  }
  const auto found = num_numbers.find(type);
  require(found != num_numbers.end(), "it has a transform of an unknown type");
  bytes.skip(found->second * number);
}

struct ValueType {
  std::int64_t size = 4;         // [bytes] of a value
  std::int64_t stored_size = 4;  // [bytes] of one in an array of values: halved where floats are stored as halves
};

/// One tree, in the order in which it is stored: its nodes from the root down, then the values of its leaves.
class Tree {
 public:
  Tree(Bytes& bytes, ValueType type, std::uint32_t compression)
      : bytes_(bytes), type_(type), compression_(compression) {}

  void walk() {
    require(bytes_.number<std::int32_t>() == 1, "it has several buffers");
    bytes_.skip(type_.size);  // the background's value
    const std::int64_t num_tiles = bytes_.number<std::uint32_t>(), num_children = bytes_.number<std::uint32_t>();
    bytes_.skip(num_tiles * (place + type_.size + 1));
    for (std::int64_t child = 0; child < num_children; ++child) {
      bytes_.skip(place);
      walk_internal_node(5);
    }
    for (const int num_active : active_in_leaves_) walk_leaf(num_active);
  }

 private:
  static constexpr std::int64_t place = 12;  // [bytes] of a node's corner
  static constexpr int leaf_bits = 512;

  void walk_internal_node(int log2_width) {
    const int num_bits = 1 << 3 * log2_width;
    const std::vector<std::uint64_t> children = bytes_.mask(num_bits), active = bytes_.mask(num_bits);
    for (std::size_t word = 0; word < children.size(); ++word)
      require((children[word] & active[word]) == 0, "a tile is a node as well");
    walk_values(num_bits, num_on(active));
    for (int left = num_on(children); left > 0; --left) {
      if (log2_width == 5)
        walk_internal_node(4);
      else
        active_in_leaves_.push_back(num_on(bytes_.mask(leaf_bits)));
    }
  }

  void walk_leaf(int num_active) {
    require(num_on(bytes_.mask(leaf_bits)) == num_active, "a leaf has two numbers of voxels");
    walk_values(leaf_bits, num_active);
  }

  /// The values of a node; with active_mask, inactive ones are told by a few bytes.
  void walk_values(int count, int num_active) {
    enum { one_inactive = 2, mask_alone, mask_and_one, mask_and_two, all_values };
    const auto kind = bytes_.number<std::int8_t>();
    require(kind >= 0 && kind <= all_values, "a node of an unknown kind");
    if (kind == one_inactive || kind == mask_and_one) bytes_.skip(type_.size);
    if (kind == mask_and_two) bytes_.skip(2 * type_.size);
    if (kind == mask_alone || kind == mask_and_one || kind == mask_and_two) bytes_.skip(count / 8);
    walk_block(compression_ & with_active_mask && kind != all_values ? num_active : count);
  }

  void walk_block(int count) {
    const std::int64_t size = count * type_.stored_size;
    if (size == 0 && type_.stored_size != type_.size) return;  // halves: nothing is stored of nothing
    if (!(compression_ & (with_blosc | with_zip))) return bytes_.skip(size);
    const auto stored = bytes_.number<std::int64_t>();
    require(stored > 0 || stored == -size, fmt::format("a block of {} bytes for {}", stored, size));
    const std::int64_t start = bytes_.at();
    if (stored > 0 && compression_ & with_blosc) check_blosc_header(stored, size);
    bytes_.go_to(start);
    bytes_.skip(stored > 0 ? stored : size);
  }

  /// Blosc believes the sizes in its own header.
  void check_blosc_header(std::int64_t stored, std::int64_t size) {
    bytes_.skip(4);  // versions, flags, size of a number
    const auto raw = bytes_.number<std::uint32_t>();
    bytes_.skip(4);  // size of a block
    const auto packed = bytes_.number<std::uint32_t>();
    require(raw == size && packed == stored, fmt::format("a compressed block of {} bytes for {}", packed, raw));
  }

  Bytes& bytes_;
  ValueType type_;
  std::uint32_t compression_ = 0;
  std::vector<int> active_in_leaves_;
};

/// [bytes] of a value of the grid; no_size where its tree is not walked.
std::int64_t value_size(std::string grid_type) {
  const std::string half = "_HalfFloat";
  if (grid_type.ends_with(half)) grid_type.resize(grid_type.size() - half.size());
  if (grid_type == "Tree_float_5_4_3") return 4;
  return grid_type == "Tree_vec3s_5_4_3" ? 12 : no_size;
}

void walk_grid(Bytes& bytes, bool has_places) {
  bytes.string();  // its name
  const std::int64_t size = value_size(bytes.string());
  const bool is_known = size != no_size;
  const bool shares_a_tree = !bytes.string().empty();
  const auto start = bytes.number<std::int64_t>();
  bytes.number<std::int64_t>();  // where its values begin, not used
  const auto end = bytes.number<std::int64_t>();
  if (has_places) {
    require(start >= bytes.at() && end >= start && end <= bytes.size(),
            fmt::format("a grid lies at bytes {} to {} of {}", start, end, bytes.size()));
    bytes.go_to(start);
  }
  const auto compression = bytes.number<std::uint32_t>();
  const bool as_halves = walk_metadata(bytes);
  if (is_known) walk_transform(bytes);
  if (is_known && !shares_a_tree) Tree(bytes, {size, as_halves ? size / 2 : size}, compression).walk();
  require(has_places || is_known, "it was written to a stream and has grids of a type that is not read");
  if (!has_places) return;
  require(bytes.at() <= end, "a grid goes on beyond its end");
  bytes.go_to(end);
}

}  // namespace

void check_vdb_promises(const std::filesystem::path& path) {
  Bytes bytes(path);
  require(bytes.number<std::int64_t>() == magic, "not a VDB file");
  const auto format = bytes.number<std::uint32_t>();
  require(format >= oldest_format && format <= newest_format,
          fmt::format("its format is {}, read are 222 to 224", format));
  bytes.skip(8);  // the library's version
  const bool has_places = bytes.number<char>() != 0;
  bytes.skip(36);  // an identifier
  walk_metadata(bytes);
  const auto num_grids = bytes.number<std::int32_t>();
  require(num_grids >= 0, fmt::format("it has {} grids", num_grids));
  for (int grid = 0; grid < num_grids; ++grid) walk_grid(bytes, has_places);
}

}  // namespace umax
