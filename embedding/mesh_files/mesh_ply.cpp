// PLY: text and binary of either byte order, polygons and triangle strips, colours and texture coordinates.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/files/read_file.h"
#include "embedding/mesh_files/mesh_assembly.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/mesh_record/mesh_materials.h"
#include "embedding/scanning/mesh_scanner.h"
#include "embedding/scanning/raw_numbers.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

struct PlyProperty {
  std::string name;
  NumberType type = NumberType::float32;  // of a list: of its items
  std::optional<NumberType> count_type;   // of a list
};

struct PlyElement {
  std::string name;
  long long count = 0;
  std::vector<PlyProperty> properties;
};

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(" \t", at)) != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.emplace_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// What a vertex's numbers mean: its place in (x, y, z, red, green, blue, u, v); -1: nothing to us.
int role_of(const std::string& name) {
  static const std::map<std::string, int> roles{{"x", 0},
                                                {"y", 1},
                                                {"z", 2},
                                                {"red", 3},
                                                {"green", 4},
                                                {"blue", 5},
                                                {"diffuse_red", 3},
                                                {"u", 6},
                                                {"s", 6},
                                                {"texture_u", 6},
                                                {"texture_s", 6},
                                                {"v", 7},
                                                {"t", 7},
                                                {"diffuse_green", 4},
                                                {"r", 3},
                                                {"g", 4},
                                                {"b", 5},
                                                {"texture_v", 7},
                                                {"diffuse_blue", 5},
                                                {"texture_t", 7}};
  const auto found = roles.find(name);
  return found == roles.end() ? -1 : found->second;
}

int to_index(double number) {
  return number >= 0 && number <= std::numeric_limits<int>::max() ? int(number) : -1;
}

class PlyReader {
 public:
  PlyReader(const Path& path, const std::string& text) : path_(path), scan_(path, text) {}

  MeshFile read() {
    read_header();
    for (const PlyElement& element : elements_) {
      require_room(element);
      if (element.name == "vertex")
        read_vertices(element);
      else if (element.name == "face" || element.name == "tristrips")
        read_faces(element);
      else
        skip(element);
    }
    MeshFile file = mesh_.finish(path_);
    if (!texture_.empty() && file.mesh.texture_coordinates.rows() > 0)
      if (Path texture = find_texture(path_, texture_, file.notes); !texture.empty())
        file.materials.push_back({.name = "", .texture = std::move(texture)});
    return file;
  }

 private:
  void read_header() {
    if (!scan_.line().starts_with("ply")) scan_.refuse("does not begin with \"ply\"");
    std::string format;
    while (true) {
      if (scan_.at_end()) scan_.refuse("has a header without end_header");
      const std::string_view line = scan_.line();
      const std::vector<std::string> words = words_of(line);
      if (words.empty()) continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format" && words.size() > 1) format = words[1];
      if (words[0] == "element") read_element(words);
      if (words[0] == "property") read_property(words);
      if (words[0] == "comment" && words.size() > 2 && words[1] == "TextureFile")
        texture_ = line.substr(line.find(words[2], line.find(words[1]) + words[1].size()));
    }
    is_text_ = format == "ascii";
    big_endian_ = format == "binary_big_endian";
    if (!is_text_ && !big_endian_ && format != "binary_little_endian")
      scan_.refuse("is of a PLY format that is not known", '"' + format + '"', "save it as binary or text PLY");
  }

  void read_element(const std::vector<std::string>& words) {
    PlyElement element;
    if (words.size() < 3) scan_.refuse("has an element without name or count");
    element.name = words[1];
    MeshScanner count(path_, words[2], "header");
    element.count = count.integer("an element's count");
    if (element.count < 0 || element.count > std::numeric_limits<int>::max())
      scan_.refuse(fmt::format("has a count of \"{}\" that cannot be", element.name), words[2]);
    elements_.push_back(std::move(element));
  }

  void read_property(const std::vector<std::string>& words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (elements_.empty() || words.size() < (is_list ? 5u : 3u)) scan_.refuse("has a property that cannot be read");
    PlyProperty property;
    if (is_list) property.count_type = type_of(words[2]);
    property.type = type_of(words[is_list ? 3 : 1]);
    property.name = words[is_list ? 4 : 2];
    elements_.back().properties.push_back(std::move(property));
  }

  NumberType type_of(const std::string& word) const {
    static const std::map<std::string, NumberType> types{
        {"char", NumberType::int8},      {"int8", NumberType::int8},       {"uchar", NumberType::uint8},
        {"uint8", NumberType::uint8},    {"short", NumberType::int16},     {"int16", NumberType::int16},
        {"ushort", NumberType::uint16},  {"uint16", NumberType::uint16},   {"int", NumberType::int32},
        {"int32", NumberType::int32},    {"uint", NumberType::uint32},     {"uint32", NumberType::uint32},
        {"float", NumberType::float32},  {"float32", NumberType::float32}, {"double", NumberType::float64},
        {"float64", NumberType::float64}};
    const auto found = types.find(word);
    if (found == types.end()) scan_.refuse("has a property of a type that is not known", '"' + word + '"');
    return found->second;
  }

  void require_room(const PlyElement& element) const {
    long long bytes = 0;
    for (const PlyProperty& property : element.properties)
      bytes += is_text_ ? 2 : size_of(property.count_type.value_or(property.type));
    if (bytes > 0) scan_.require_room(element.count, bytes, ("things named " + element.name).c_str());
  }

  double number(NumberType type) {
    if (is_text_) return scan_.number("an entry");
    return decode_number(scan_.bytes(std::size_t(size_of(type))).data(), type, big_endian_);
  }

  /// Reads a list; null: steps over it.
  void read_list(const PlyProperty& property, std::vector<double>* items) {
    const double count = number(*property.count_type);
    if (!(count >= 0)) scan_.refuse("has a list with a negative count");
    scan_.require_room((long long)(std::min(count, 1e15)), is_text_ ? 2 : size_of(property.type), "entries of a list");
    if (items) items->clear();
    for (long long i = 0; i < (long long)(count); ++i) {
      const double item = number(property.type);
      if (items) items->push_back(item);
    }
  }

  void skip(const PlyElement& element) {
    for (long long i = 0; i < (element.properties.empty() ? 0 : element.count); ++i)
      for (const PlyProperty& property : element.properties)
        property.count_type ? read_list(property, nullptr) : void(number(property.type));
  }

  void read_vertices(const PlyElement& element) {
    if (mesh_.file.mesh.num_vertices() > 0) scan_.refuse("has vertices twice");
    std::array<bool, 8> has{};
    std::vector<int> roles;
    double scale = 1;  // of colours
    for (const PlyProperty& property : element.properties) {
      roles.push_back(property.count_type ? -1 : role_of(property.name));
      if (roles.back() >= 0) has[std::size_t(roles.back())] = true;
      if (roles.back() == 3 && property.type == NumberType::uint8) scale = 255;
      if (roles.back() == 3 && property.type == NumberType::uint16) scale = 65535;
    }
    if (!has[0] || !has[1] || !has[2]) scan_.refuse("has vertices without x, y and z");
    if (element.count < 1) scan_.refuse("has no vertices");
    Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor> values =
        Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>::Zero(element.count, 8);
    for (Eigen::Index v = 0; v < element.count; ++v)
      for (std::size_t p = 0; p < roles.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.count_type)
          read_list(property, nullptr);
        else if (const double value = number(property.type); roles[p] >= 0)
          values(v, roles[p]) = value;
      }
    mesh_.file.mesh.positions = values.leftCols<3>();
    if (has[3] && has[4] && has[5]) mesh_.file.mesh.colors = linear_colors(values.middleCols<3>(3) / scale);
    if (has[6] && has[7]) coordinates_ = values.rightCols<2>().cast<float>();
  }

  void read_faces(const PlyElement& element) {
    std::vector<double> corners, coordinates;
    for (long long face = 0; face < (element.properties.empty() ? 0 : element.count); ++face) {
      corners.clear();
      coordinates.clear();
      for (const PlyProperty& property : element.properties) {
        if (!property.count_type)
          number(property.type);
        else if (property.name == "vertex_indices" || property.name == "vertex_index")
          read_list(property, &corners);
        else
          read_list(property, property.name == "texcoord" ? &coordinates : nullptr);
      }
      element.name == "face" ? add_face(face, corners, coordinates) : add_strip(face, corners);
    }
  }

  void add_face(long long face, const std::vector<double>& corners, const std::vector<double>& coordinates) {
    polygon_.clear();
    for (const double corner : corners) polygon_.push_back(to_index(corner));
    mesh_.add_polygon(path_, face, polygon_);
    for (const auto& triangle : mesh_.cut)
      for (const int place : triangle) {
        if (coordinates.size() == 2 * corners.size())
          mesh_.coordinates.emplace_back(float(coordinates[std::size_t(2 * place)]),
                                         float(coordinates[std::size_t(2 * place) + 1]));
        else if (coordinates_.rows() > 0)
          mesh_.coordinates.push_back(coordinates_.row(polygon_[std::size_t(place)]).transpose());
      }
  }

  /// Triangles that each share an edge with the one before, turned every other time; -1 begins anew.
  void add_strip(long long strip, const std::vector<double>& corners) {
    std::vector<double> triangle(3);
    std::size_t length = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      length = corners[i] < 0 ? 0 : length + 1;
      if (length < 3) continue;
      const bool turned = length % 2 == 0;
      triangle = {corners[i - 2], corners[turned ? i : i - 1], corners[turned ? i - 1 : i]};
      // strips go around corners by triangles that are none
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        add_face(strip, triangle, {});
    }
  }

  Path path_;
  MeshScanner scan_;
  bool is_text_ = false, big_endian_ = false;
  std::string texture_;
  std::vector<PlyElement> elements_;
  TextureCoordinates coordinates_;  // #V x 2, or empty
  MeshAssembly mesh_;
  std::vector<int> polygon_;
};

}  // namespace

MeshFile read_ply(const Path& path) {
  const std::string text = read_file(path);
  return PlyReader(path, text).read();
}

}  // namespace umax
