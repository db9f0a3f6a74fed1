// Gmsh .msh, formats 1 (text), 2, 4.0 and 4.1 (text and binary, little-endian).
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <unordered_map>

#include "embedding/hex_files/hex_mesh_formats.h"
#include "embedding/scanning/mesh_scanner.h"

namespace umax {
namespace {

class GmshReader {
 public:
  GmshReader(const std::filesystem::path& path, const std::string& text) : scan_(path, text) {
    file_.cell_word = "element";
  }

  HexFile read() {
    while (!scan_.at_end()) {
      const std::string section(scan_.word());
      if (!section.starts_with('$'))
        scan_.refuse("must begin a section such as $Nodes", '"' + section.substr(0, 40) + '"');
      require_order(section);
      if (!read_section(section)) {
        scan_.skip_past("$End" + section.substr(1));
        continue;
      }
      const std::string end = (version_ == Version::v1 ? "$END" : "$End") + section.substr(1);
      if (scan_.at_end() || scan_.peek() != end)
        scan_.refuse("has no \"" + end + "\" where it should end", std::string(scan_.peek().substr(0, 40)));
      scan_.word();
    }
    if (version_ == Version::none || !has_nodes_ || !has_elements_)
      scan_.refuse(version_ == Version::none ? "has no $MeshFormat"
                   : !has_nodes_             ? "has no $Nodes"
                                             : "has no $Elements");
    return std::move(file_);
  }

 private:
  [[noreturn]] void refuse_version(const std::string& version) const {
    scan_.refuse("is of a version of Gmsh's format that is not read", version,
                 "save it as version 4.1 or 2.2: gmsh IN.msh -save -format msh41 -o OUT.msh");
  }

  enum class Version { none, v1, v2, v4_0, v4_1 };

  /// Format 1 says what it is by the names of its sections.
  void require_order(const std::string& section) {
    if (version_ == Version::none && section == "$NOD") version_ = Version::v1;
    if (section != "$MeshFormat" && version_ == Version::none) scan_.refuse("has no $MeshFormat before it", section);
    const bool nodes = section == "$Nodes" || section == "$NOD", elements = section == "$Elements" || section == "$ELM";
    if ((nodes && has_nodes_) || (elements && has_elements_)) scan_.refuse("comes a second time", section);
    if (elements && !has_nodes_) scan_.refuse("comes before $Nodes", section);
    has_nodes_ |= nodes;
    has_elements_ |= elements;
  }

  /// False for a section that means nothing to us.
  bool read_section(const std::string& section) {
    if (section == "$MeshFormat") return read_format(), true;
    if (section == (version_ == Version::v1 ? "$NOD" : "$Nodes")) return read_nodes(), true;
    if (section == (version_ == Version::v1 ? "$ELM" : "$Elements")) return read_elements(), true;
    return false;
  }

  void read_nodes() {
    if (version_ == Version::v1 || version_ == Version::v2) return read_nodes_2();
    version_ == Version::v4_0 ? read_nodes_4_0() : read_nodes_4_1();
  }
  void read_elements() {
    if (version_ == Version::v1) return read_elements_1();
    if (version_ == Version::v2) return read_elements_2();
    version_ == Version::v4_0 ? read_elements_4_0() : read_elements_4_1();
  }

  void read_format() {
    const std::string version(scan_.word());
    if (version == "2" || version == "2.1" || version == "2.2")
      version_ = Version::v2;
    else if (version == "4" || version == "4.0")
      version_ = Version::v4_0;
    else if (version == "4.1")
      version_ = Version::v4_1;
    else
      refuse_version(version);
    binary_ = scan_.integer("the file type") == 1;
    if (const long long size = scan_.integer("the data size"); size != 8)
      scan_.refuse("has numbers of a size that is not read", std::to_string(size), "save it with 8-byte numbers");
    if (!binary_) return;
    scan_.skip_line_end();
    if (raw<std::int32_t>() != 1)
      scan_.refuse("is binary of the other byte order", "", "save it as text, or on a little-endian machine");
  }

  template <class T>
  T raw() {
    T value;
    const std::string_view bytes = scan_.bytes(sizeof value);
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  // numbers that are text or binary by the file's kind: int of C, size_t of C, double
  long long small(const char* meaning) { return binary_ ? raw<std::int32_t>() : scan_.integer(meaning); }
  long long large(const char* meaning) { return binary_ ? (long long)(raw<std::uint64_t>()) : scan_.integer(meaning); }
  double real(const char* meaning) { return binary_ ? raw<double>() : scan_.number(meaning); }

  void add_node(long long id, const Vector3d& position) {
    if (!index_.emplace(id, int(file_.nodes.size())).second) scan_.refuse(fmt::format("node {} is given twice", id));
    file_.nodes.push_back(position);
    file_.node_ids.push_back(id);
  }

  Vector3d position() {
    Vector3d x;
    for (double& component : x) component = real("a coordinate");
    return x;
  }

  const CellKind& kind_of(long long type) const {
    const CellKind* kind = type > 0 && type < 1000 ? gmsh_cell_kind(int(type)) : nullptr;
    if (!kind)
      scan_.refuse("has elements of a type that is not known", std::to_string(type), "write 8-node hexahedra (type 5)");
    return *kind;
  }

  // reads the nodes of an element with next() and adds it
  template <class Next>
  void read_element(const CellKind& kind, long long id, Next next) {
    std::array<int, 8> nodes{};
    const bool is_hex = kind.dimension == 3 && kind.num_nodes == 8;
    for (int n = 0; n < kind.num_nodes; ++n) {
      const long long node = next();
      if (!is_hex) continue;
      const auto found = index_.find(node);
      if (found == index_.end())
        scan_.refuse(fmt::format("element {} names node {}, which the file does not have", id, node));
      nodes[std::size_t(n)] = found->second;
    }
    add_cell(file_, kind, id, nodes.data());
  }

  void read_nodes_2() {
    const long long count = scan_.integer("the number of nodes");
    scan_.require_room(count, binary_ ? 28 : 8, "nodes");
    if (binary_) scan_.skip_line_end();
    for (long long i = 0; i < count; ++i) {
      const long long id = small("a node's number");
      add_node(id, position());
    }
  }

  void read_elements_1() {
    const long long count = scan_.integer("the number of elements");
    scan_.require_room(count, 12, "elements");
    for (long long i = 0; i < count; ++i) {
      const long long id = scan_.integer("an element's number");
      const CellKind& kind = kind_of(scan_.integer("an element's type"));
      scan_.integer("a region"), scan_.integer("an entity's number");
      if (const long long nodes = scan_.integer("the number of nodes"); kind.num_nodes >= 0 && nodes != kind.num_nodes)
        scan_.refuse(fmt::format("gives element {} a wrong number of nodes", id),
                     fmt::format("{} of {}", nodes, kind.num_nodes));
      read_element(kind, id, [&] { return scan_.integer("a node's number"); });
    }
  }

  void read_elements_2() {
    const long long count = scan_.integer("the number of elements");
    scan_.require_room(count, binary_ ? 8 : 6, "elements");
    if (binary_) scan_.skip_line_end();
    for (long long done = 0; done < count;) {
      // text: number, type, tags, nodes; binary: type, how many of it follow, tags of each
      const long long text_id = binary_ ? 0 : small("an element's number");
      const CellKind& kind = kind_of(small("an element's type"));
      const long long block = binary_ ? small("a number of elements") : 1;
      const long long num_tags = small("the number of tags");
      if (block < 1 || block > count - done || num_tags < 0)
        scan_.refuse("has a wrong number of elements or tags", fmt::format("{}, {}", block, num_tags));
      for (long long i = 0; i < block; ++i) {
        const long long id = binary_ ? small("an element's number") : text_id;
        for (long long t = 0; t < num_tags; ++t) small("a tag");
        read_element(kind, id, [&] { return small("a node's number"); });
      }
      done += block;
    }
  }

  /// Block after block of nodes of one entity; a node's number stands before its position.
  void read_nodes_4_0() {
    if (binary_) scan_.skip_line_end();
    const long long blocks = large("the number of blocks");
    long long left = large("the number of nodes");
    scan_.require_room(blocks, binary_ ? 20 : 8, "blocks");
    scan_.require_room(left, binary_ ? 28 : 8, "nodes");
    for (long long b = 0; b < blocks; ++b) {
      small("an entity's number");
      const long long dimension = small("a dimension");
      const bool parametric = small("parametric or not") != 0;
      for (long long count = block_size("nodes", left); count > 0; --count) {
        const long long id = small("a node's number");
        add_node(id, position());
        for (long long k = 0; parametric && k < dimension; ++k) real("a parameter");
      }
    }
    if (left != 0) scan_.refuse("holds fewer nodes than promised", fmt::format("{} are missing", left));
  }

  void read_elements_4_0() {
    if (binary_) scan_.skip_line_end();
    const long long blocks = large("the number of blocks");
    long long left = large("the number of elements");
    scan_.require_room(blocks, binary_ ? 20 : 8, "blocks");
    scan_.require_room(left, binary_ ? 8 : 4, "elements");
    for (long long b = 0; b < blocks; ++b) {
      small("an entity's number"), small("a dimension");
      const CellKind& kind = kind_of(small("an element's type"));
      for (long long count = block_size("elements", left); count > 0; --count) {
        const long long id = small("an element's number");
        read_element(kind, id, [&] { return small("a node's number"); });
      }
    }
    if (left != 0) scan_.refuse("holds fewer elements than promised", fmt::format("{} are missing", left));
  }

  /// The number of things in the block that begins, which are taken from those that are left.
  long long block_size(const char* things, long long& left) {
    const long long count = large("a block's size");
    if (count < 0 || count > left)
      scan_.refuse(fmt::format("has a block with more {} than promised", things), fmt::format("{} of {}", count, left));
    left -= count;
    return count;
  }

  struct Blocks {
    long long blocks = 0, things = 0;
  };
  Blocks read_blocks_4_1(const char* things, int bytes_each) {
    if (binary_) scan_.skip_line_end();
    Blocks header;
    header.blocks = large("the number of blocks");
    header.things = large("the number of things");
    large("the least number"), large("the largest number");
    scan_.require_room(header.blocks, binary_ ? 20 : 8, "blocks");
    scan_.require_room(header.things, bytes_each, things);
    return header;
  }

  void read_nodes_4_1() {
    const Blocks header = read_blocks_4_1("nodes", binary_ ? 32 : 8);
    long long left = header.things;
    for (long long b = 0; b < header.blocks; ++b) {
      const long long dimension = small("a dimension");
      small("an entity's number");
      const bool parametric = small("parametric or not") != 0;
      const long long count = block_size("nodes", left);
      if (dimension < 0 || dimension > 3) scan_.refuse("has a block of a wrong dimension", std::to_string(dimension));
      std::vector<long long> ids;
      for (long long i = 0; i < count; ++i) ids.push_back(large("a node's number"));
      for (const long long id : ids) {
        add_node(id, position());
        for (long long k = 0; parametric && k < dimension; ++k) real("a parameter");
      }
    }
    if (left != 0) scan_.refuse("holds fewer nodes than promised", fmt::format("{} are missing", left));
  }

  void read_elements_4_1() {
    const Blocks header = read_blocks_4_1("elements", binary_ ? 16 : 4);
    long long left = header.things;
    for (long long b = 0; b < header.blocks; ++b) {
      small("a dimension"), small("an entity's number");
      const CellKind& kind = kind_of(small("an element's type"));
      const long long count = block_size("elements", left);
      for (long long i = 0; i < count; ++i) {
        const long long id = large("an element's number");
        read_element(kind, id, [&] { return large("a node's number"); });
      }
    }
    if (left != 0) scan_.refuse("holds fewer elements than promised", fmt::format("{} are missing", left));
  }

  MeshScanner scan_;
  HexFile file_;
  std::unordered_map<long long, int> index_;  // of a node by its number in the file
  Version version_ = Version::none;
  bool binary_ = false, has_nodes_ = false, has_elements_ = false;
};

}  // namespace

HexFile read_gmsh(const std::filesystem::path& path, const std::string& text) {
  return GmshReader(path, text).read();
}

}  // namespace umax
