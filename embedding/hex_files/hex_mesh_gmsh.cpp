// Gmsh .msh, formats 2.2 and 4.1, as text and binary (little-endian).
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
    bool has_format = false, has_nodes = false, has_elements = false;
    while (!scan_.at_end()) {
      const std::string section(scan_.word());
      if (!section.starts_with('$'))
        scan_.refuse("must begin a section such as $Nodes", '"' + section.substr(0, 40) + '"');
      if (section == "$NOD" || section == "$ELM") refuse_version("1");
      if (section != "$MeshFormat" && !has_format) scan_.refuse("has no $MeshFormat before it", section);
      if ((section == "$Nodes" && has_nodes) || (section == "$Elements" && has_elements))
        scan_.refuse("comes a second time", section);
      if (section == "$Elements" && !has_nodes) scan_.refuse("comes before $Nodes", section);
      if (section == "$MeshFormat") {
        read_format();
        has_format = true;
      } else if (section == "$Nodes") {
        version_ == 2 ? read_nodes_2() : read_nodes_4();
        has_nodes = true;
      } else if (section == "$Elements") {
        version_ == 2 ? read_elements_2() : read_elements_4();
        has_elements = true;
      } else {
        scan_.skip_past("$End" + section.substr(1));
        continue;
      }
      const std::string end = "$End" + section.substr(1);
      if (scan_.at_end() || scan_.peek() != end)
        scan_.refuse("has no \"" + end + "\" where it should end", std::string(scan_.peek().substr(0, 40)));
      scan_.word();
    }
    if (!has_format || !has_nodes || !has_elements)
      scan_.refuse(!has_format ? "has no $MeshFormat" : !has_nodes ? "has no $Nodes" : "has no $Elements");
    return std::move(file_);
  }

 private:
  [[noreturn]] void refuse_version(const std::string& version) const {
    scan_.refuse("is of a version of Gmsh's format that is not read", version,
                 "save it as version 4.1 or 2.2: gmsh IN.msh -save -format msh41 -o OUT.msh");
  }

  void read_format() {
    const std::string version(scan_.word());
    if (version == "2" || version == "2.1" || version == "2.2")
      version_ = 2;
    else if (version == "4.1")
      version_ = 4;
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

  struct Blocks {
    long long blocks = 0, things = 0;
  };
  Blocks read_blocks_4(const char* things, int bytes_each) {
    if (binary_) scan_.skip_line_end();
    Blocks header;
    header.blocks = large("the number of blocks");
    header.things = large("the number of things");
    large("the least number"), large("the largest number");
    scan_.require_room(header.blocks, binary_ ? 20 : 8, "blocks");
    scan_.require_room(header.things, bytes_each, things);
    return header;
  }

  void read_nodes_4() {
    const Blocks header = read_blocks_4("nodes", binary_ ? 32 : 8);
    long long left = header.things;
    for (long long b = 0; b < header.blocks; ++b) {
      const long long dimension = small("a dimension");
      small("an entity's number");
      const bool parametric = small("parametric or not") != 0;
      const long long count = large("a block's number of nodes");
      if (count < 0 || count > left || dimension < 0 || dimension > 3)
        scan_.refuse("has a block with more nodes than promised", fmt::format("{} of {}", count, left));
      left -= count;
      std::vector<long long> ids;
      for (long long i = 0; i < count; ++i) ids.push_back(large("a node's number"));
      for (const long long id : ids) {
        add_node(id, position());
        for (long long k = 0; parametric && k < dimension; ++k) real("a parameter");
      }
    }
    if (left != 0) scan_.refuse("holds fewer nodes than promised", fmt::format("{} are missing", left));
  }

  void read_elements_4() {
    const Blocks header = read_blocks_4("elements", binary_ ? 16 : 4);
    long long left = header.things;
    for (long long b = 0; b < header.blocks; ++b) {
      small("a dimension"), small("an entity's number");
      const CellKind& kind = kind_of(small("an element's type"));
      const long long count = large("a block's number of elements");
      if (count < 0 || count > left)
        scan_.refuse("has a block with more elements than promised", fmt::format("{} of {}", count, left));
      left -= count;
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
  int version_ = 0;
  bool binary_ = false;
};

}  // namespace

HexFile read_gmsh(const std::filesystem::path& path, const std::string& text) {
  return GmshReader(path, text).read();
}

}  // namespace umax
