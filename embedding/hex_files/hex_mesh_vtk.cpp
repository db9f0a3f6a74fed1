// VTK legacy .vtk: unstructured grids as text and binary (big-endian), versions 1 to 5.1.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "embedding/hex_files/hex_mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/scanning/mesh_scanner.h"
#include "embedding/scanning/raw_numbers.h"

namespace umax {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return result;
}
std::string upper(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return char(std::toupper(c)); });
  return result;
}

std::optional<NumberType> type_of(std::string_view word) {
  static const std::map<std::string, NumberType> types{
      {"char", NumberType::int8},          {"unsigned_char", NumberType::uint8},
      {"short", NumberType::int16},        {"unsigned_short", NumberType::uint16},
      {"int", NumberType::int32},          {"unsigned_int", NumberType::uint32},
      {"long", NumberType::int64},         {"unsigned_long", NumberType::uint64},
      {"vtktypeint64", NumberType::int64}, {"vtktypeuint64", NumberType::uint64},
      {"vtktypeint32", NumberType::int32}, {"vtkidtype", NumberType::int32},
      {"float", NumberType::float32},      {"double", NumberType::float64}};
  const auto found = types.find(lower(word));
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

class VtkReader {
 public:
  VtkReader(const std::filesystem::path& path, const std::string& text) : path_(path), scan_(path, text) {}

  HexFile read() {
    read_header();
    while (!scan_.at_end()) read_section();
    if (file_.nodes.empty() || !has_cells_ || !has_types_)
      scan_.refuse(file_.nodes.empty() ? "has no POINTS" : !has_cells_ ? "has no CELLS" : "has no CELL_TYPES");
    const std::size_t num_cells = cells_.types.size();
    add_vtk_cells(path_, cells_, file_);
    for (const auto& [name, values] : data_) {
      if (values.size() != num_cells)
        scan_.refuse("cell data " + name + " must be one number per cell",
                     fmt::format("{} for {} cells", values.size(), num_cells));
      add_vtk_cell_data(name, values, 0, file_);
    }
    return std::move(file_);
  }

 private:
  void read_header() {
    const std::string first(scan_.line());
    constexpr std::string_view start = "# vtk DataFile Version ";
    if (!first.starts_with(start))
      scan_.refuse("is no VTK legacy file: its first line must be \"# vtk DataFile Version …\"");
    std::from_chars(first.data() + start.size(), first.data() + first.size(), version_);
    if (version_ < 1 || version_ > 5)
      scan_.refuse("is of an unknown version", first, "save it as version 5.1 or older");
    scan_.line();  // its title
    const std::string kind = upper(scan_.word());
    if (kind != "ASCII" && kind != "BINARY") scan_.refuse("must be ASCII or BINARY", kind.substr(0, 40));
    binary_ = kind == "BINARY";
  }

  void read_section() {
    const std::string section = upper(scan_.word());
    if (section == "DATASET") {
      const std::string kind = upper(scan_.word());
      if (kind != "UNSTRUCTURED_GRID")
        scan_.refuse("holds no unstructured grid", kind.substr(0, 40), "save it as an unstructured grid of hexahedra");
    } else if (section == "POINTS") {
      read_points();
    } else if (section == "CELLS") {
      read_cells();
    } else if (section == "CELL_TYPES") {
      if (std::exchange(has_types_, true)) scan_.refuse("has CELL_TYPES twice");
      cells_.types = values(NumberType::int32, scan_.integer("the number of cells"), "cell types");
    } else if (section == "CELL_DATA" || section == "POINT_DATA") {
      for_cells_ = section == "CELL_DATA";
      num_tuples_ = scan_.integer("the number of values");
    } else if (section == "METADATA") {
      scan_.line();
      while (!scan_.line().empty()) {
      }
    } else {
      read_attribute(section);
    }
  }

  void read_points() {
    if (!file_.nodes.empty()) scan_.refuse("has POINTS twice");
    const long long count = scan_.integer("the number of points");
    const std::vector<double> x = values(named_type(), product(3, count), "coordinates");
    for (std::size_t i = 0; i + 2 < x.size(); i += 3) file_.nodes.emplace_back(x[i], x[i + 1], x[i + 2]);
  }

  void read_cells() {
    if (std::exchange(has_cells_, true)) scan_.refuse("has CELLS twice");
    const long long first = scan_.integer("the number of cells"), size = scan_.integer("the size of the cells");
    if (version_ >= 5) {
      require_word("OFFSETS");
      cells_.ends = values(named_type(), first, "offsets");
      if (!cells_.ends.empty() && cells_.ends.front() != 0) scan_.refuse("the offsets of the cells must begin with 0");
      if (!cells_.ends.empty()) cells_.ends.erase(cells_.ends.begin());
      require_word("CONNECTIVITY");
      cells_.nodes = values(named_type(), size, "node numbers");
      return;
    }
    // every cell: how many nodes, and they
    const std::vector<double> list = values(NumberType::int32, size, "numbers of cells");
    std::size_t at = 0;
    for (long long c = 0; c < first; ++c) {
      const double count = at < list.size() ? list[at] : -1;
      if (!(count >= 0 && count <= double(list.size() - at - 1)))
        scan_.refuse(fmt::format("the list of cells ends within cell {} of {}", c, first));
      const auto begin = list.begin() + std::ptrdiff_t(at) + 1;
      cells_.nodes.insert(cells_.nodes.end(), begin, begin + std::ptrdiff_t(count));
      cells_.ends.push_back(double(cells_.nodes.size()));
      at += 1 + std::size_t(count);
    }
    if (at != list.size())
      scan_.refuse("the list of cells is longer than its cells", fmt::format("{} of {} numbers", at, list.size()));
  }

  void read_attribute(const std::string& kind) {
    static const std::map<std::string, int> components{{"VECTORS", 3},   {"NORMALS", 3},    {"TENSORS", 9},
                                                       {"TENSORS6", 6},  {"GLOBAL_IDS", 1}, {"PEDIGREE_IDS", 1},
                                                       {"EDGE_FLAGS", 1}};
    static const std::set<std::string> others{"FIELD", "SCALARS", "COLOR_SCALARS", "LOOKUP_TABLE",
                                              "TEXTURE_COORDINATES"};
    if (!components.count(kind) && !others.count(kind))
      scan_.refuse("has an unknown keyword", '"' + kind.substr(0, 40) + '"');
    const std::string name(scan_.word());
    if (kind == "FIELD") {
      read_field(scan_.integer("the number of arrays"));
    } else if (kind == "SCALARS") {
      const std::optional<NumberType> type = optional_type();
      const bool one = upper(scan_.peek()) == "LOOKUP_TABLE";
      const long long width = one ? 1 : scan_.integer("the number of components");
      require_word("LOOKUP_TABLE");
      scan_.word();
      keep(name, width, num_tuples_, type);
    } else if (kind == "COLOR_SCALARS" || kind == "LOOKUP_TABLE") {
      const long long number = scan_.integer("a number of values");
      const long long count = kind == "LOOKUP_TABLE" ? product(4, number) : product(number, num_tuples_);
      values(binary_ ? NumberType::uint8 : NumberType::float32, count, "colours");
    } else {
      const bool texture = kind == "TEXTURE_COORDINATES";
      const long long width = texture ? scan_.integer("the number of components") : components.at(kind);
      keep({}, width, num_tuples_, optional_type());
    }
  }

  void read_field(long long num_arrays) {
    for (long long i = 0; i < num_arrays; ++i) {
      while (scan_.peek() == "METADATA") read_section();
      const std::string name(scan_.word());
      const long long width = scan_.integer("the number of components");
      const long long tuples = scan_.integer("the number of tuples");
      keep(name, width, tuples, optional_type());
    }
  }

  static long long product(long long a, long long b) {
    return a < 0 || b < 0 ? -1 : a > most / std::max(1LL, b) ? most : a * b;
  }

  std::optional<NumberType> optional_type() {
    const std::string_view word = scan_.word();
    if (lower(word) == "bit") return std::nullopt;
    if (const auto type = type_of(word)) return type;
    scan_.refuse("has numbers of an unknown type", '"' + std::string(word.substr(0, 40)) + '"');
  }
  NumberType named_type() {
    const std::optional<NumberType> type = optional_type();
    if (!type) scan_.refuse("has bits where numbers are needed");
    return *type;
  }
  // type: none for bits
  void keep(const std::string& name, long long width, long long tuples, std::optional<NumberType> type) {
    const long long count = product(width, tuples);
    if (!type) {
      values(NumberType::uint8, binary_ ? (count + 7) / 8 : count, "bits");
      return;
    }
    std::vector<double> numbers = values(*type, count, "values");
    if (for_cells_ && is_known_cell_data(name)) data_[name] = std::move(numbers);
  }

  void require_word(const char* wanted) {
    const std::string found = upper(scan_.word());
    if (found != wanted) scan_.refuse(fmt::format("must have {} here", wanted), '"' + found.substr(0, 40) + '"');
  }

  std::vector<double> values(NumberType type, long long count, const char* things) {
    if (binary_) {
      scan_.skip_line_end();
      scan_.require_room(count, size_of(type), things);
      return decode_numbers(scan_.bytes(std::size_t(count) * std::size_t(size_of(type))), type, true);
    }
    scan_.require_room(count, 2, things);
    std::vector<double> numbers(static_cast<std::size_t>(count));
    for (double& number : numbers) number = scan_.number("a value");
    return numbers;
  }

  static constexpr long long most = 1LL << 56;

  std::filesystem::path path_;
  MeshScanner scan_;
  HexFile file_;
  VtkCells cells_;
  std::map<std::string, std::vector<double>> data_;  // of cells, by name
  int version_ = 0;
  bool binary_ = false, has_cells_ = false, has_types_ = false;
  bool for_cells_ = false;    // the data that follow belong to cells
  long long num_tuples_ = 0;  // of them
};

}  // namespace

HexFile read_vtk_legacy(const std::filesystem::path& path, const std::string& text) {
  return VtkReader(path, text).read();
}

}  // namespace umax
