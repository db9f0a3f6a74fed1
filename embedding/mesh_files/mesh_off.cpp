// OFF, as text and binary: with normals, colours and texture coordinates of vertices ([ST][C][N]OFF).
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "core/files/read_file.h"
#include "embedding/mesh_files/mesh_assembly.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/scanning/mesh_scanner.h"
#include "embedding/scanning/raw_numbers.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

/// What the keyword says of vertices, in the order in which it stands there.
struct OffHeader {
  bool has_normals = false, has_colors = false, has_coordinates = false, is_binary = false;
  long long num_vertices = -1, num_faces = -1;
};

struct OffVertices {
  Points positions, colors;        // colours as stored, or empty
  TextureCoordinates coordinates;  // #V x 2, or empty
};

class OffReader {
 public:
  OffReader(const Path& path, const std::string& text) : path_(path), scan_(path, text) {}

  MeshFile read() {
    read_header();
    if (header_.num_vertices < 0 || header_.num_faces < 0 || header_.num_vertices > std::numeric_limits<int>::max())
      scan_.refuse("has no sound counts of vertices and faces in its header");
    const auto count = Eigen::Index(header_.num_vertices);
    scan_.require_room(count, header_.is_binary ? 12 : 6, "vertices");
    scan_.require_room(header_.num_faces, header_.is_binary ? 8 : 2, "faces");
    vertices_.positions.resize(count, 3);
    if (header_.has_colors) vertices_.colors.resize(count, 3);
    if (header_.has_coordinates) vertices_.coordinates.resize(count, 2);
    for (Eigen::Index v = 0; v < count; ++v) take_vertex(v, header_.is_binary ? binary_vertex() : text_vertex(v));
    mesh_.file.mesh.positions = std::move(vertices_.positions);
    if (header_.has_colors) mesh_.file.mesh.colors = linear_colors(vertices_.colors);
    for (long long face = 0; face < header_.num_faces; ++face) add_face(face);
    return mesh_.finish(path_);
  }

 private:
  /// The numbers of the next line that has any; what follows # is a comment.
  const std::vector<double>& next_numbers(const char* thing, long long which) {
    numbers_.clear();
    while (numbers_.empty()) {
      if (scan_.at_end()) scan_.refuse(fmt::format("ends before {} {}", thing, which));
      std::string_view line = scan_.line();
      read_numbers(line.substr(0, line.find('#')), thing, which);
    }
    return numbers_;
  }

  void read_numbers(std::string_view line, const char* thing, long long which) {
    for (std::size_t at = 0; (at = line.find_first_not_of(" \t\r", at)) != line.npos;) {
      if (line[at] == '+') ++at;
      double value = 0;
      const auto [end, error] = std::from_chars(line.data() + at, line.data() + line.size(), value);
      if (error == std::errc::invalid_argument)
        scan_.refuse(fmt::format("has something that is no number in {} {}", thing, which),
                     '"' + std::string(line.substr(at, 40)) + '"');
      numbers_.push_back(value);
      at = std::size_t(end - line.data());
    }
  }

  /// The keyword, which may be missing, and the counts, which may follow it on its line.
  void read_header() {
    std::string counts;
    bool first = true;
    while (counts.empty()) {
      if (scan_.at_end()) scan_.refuse("has no counts of vertices and faces in its header");
      std::string_view line = scan_.line();
      line = line.substr(0, line.find('#'));
      const std::size_t end = line.find("OFF");
      if (first && end != line.npos) {
        read_keyword(line.substr(0, end));
        line.remove_prefix(end + 3);
        header_.is_binary = line.find("BINARY") != line.npos;
        if (header_.is_binary) return read_binary_counts();
      }
      if (line.find_first_not_of(" \t\r") == line.npos) continue;
      first = false;
      counts = line;
    }
    MeshScanner words(path_, counts, "header");
    header_.num_vertices = words.integer("the number of vertices");
    header_.num_faces = words.integer("the number of faces");
  }

  void read_keyword(std::string_view prefix) {
    header_.has_coordinates = prefix.find("ST") != prefix.npos;
    header_.has_colors = prefix.find('C') != prefix.npos;
    header_.has_normals = prefix.find('N') != prefix.npos;
    if (prefix.find_first_of("4n") != prefix.npos)
      scan_.refuse("is of a kind of OFF with other than three coordinates", '"' + std::string(prefix) + "OFF\"",
                   "save it as plain OFF");
  }

  /// Big-endian, as the format has it; or little-endian, as some programs write it, where only that makes sense.
  void read_binary_counts() {
    const std::string_view counts = scan_.bytes(12);
    for (const bool big_endian : {true, false}) {
      big_endian_ = big_endian;
      header_.num_vertices = (long long)(decode_number(counts.data(), NumberType::int32, big_endian));
      header_.num_faces = (long long)(decode_number(counts.data() + 4, NumberType::int32, big_endian));
      constexpr long long most = 1 << 30;
      if (header_.num_vertices >= 0 && header_.num_vertices < most && header_.num_faces >= 0 &&
          scan_.has_room(header_.num_vertices, 12) && scan_.has_room(header_.num_faces, 8))
        return;
    }
    big_endian_ = true;
    header_.num_vertices = (long long)(decode_number(counts.data(), NumberType::int32, true));
    header_.num_faces = (long long)(decode_number(counts.data() + 4, NumberType::int32, true));
  }

  double binary(NumberType type) { return decode_number(scan_.bytes(4).data(), type, big_endian_); }

  const std::vector<double>& binary_vertex() {
    const int count =
        3 + (header_.has_normals ? 3 : 0) + (header_.has_colors ? 4 : 0) + (header_.has_coordinates ? 2 : 0);
    numbers_.clear();
    for (int i = 0; i < count; ++i) numbers_.push_back(binary(NumberType::float32));
    return numbers_;
  }

  const std::vector<double>& text_vertex(Eigen::Index v) {
    const std::size_t least = std::size_t(3 + (header_.has_normals ? 3 : 0) + (header_.has_colors ? 3 : 0) +
                                          (header_.has_coordinates ? 2 : 0));
    if (next_numbers("vertex", v).size() < least)
      scan_.refuse(fmt::format("has too few numbers for vertex {}", v),
                   fmt::format("{} of {}", numbers_.size(), least));
    return numbers_;
  }

  void take_vertex(Eigen::Index v, const std::vector<double>& numbers) {
    const auto at = [&](std::size_t i) { return numbers[i]; };
    vertices_.positions.row(v) << at(0), at(1), at(2);
    const std::size_t color = header_.has_normals ? 6 : 3;
    if (header_.has_colors) vertices_.colors.row(v) << at(color), at(color + 1), at(color + 2);
    if (header_.has_coordinates)  // the last two
      vertices_.coordinates.row(v) << float(at(numbers.size() - 2)), float(at(numbers.size() - 1));
  }

  void read_binary_face() {
    corners_.clear();
    const auto count = (long long)(binary(NumberType::int32));
    scan_.require_room(count, 4, "corners of a face");
    for (long long i = 0; i < count; ++i) corners_.push_back(int(binary(NumberType::int32)));
    const auto num_colors = (long long)(binary(NumberType::int32));
    scan_.require_room(num_colors, 4, "numbers of a face's colour");
    scan_.bytes(std::size_t(4 * num_colors));
  }

  void read_text_face(long long face) {
    const std::vector<double>& numbers = next_numbers("face", face);
    const double count = numbers[0];
    corners_.clear();
    if (!(count >= 0 && count <= double(numbers.size() - 1)))
      refuse_mesh(path_, "the mesh file is truncated",
                  fmt::format("face {} with {} of {} corners", face, numbers.size() - 1, count),
                  "copy or export it again");
    for (std::size_t i = 1; i <= std::size_t(count); ++i)
      corners_.push_back(std::abs(numbers[i]) < 2e9 ? int(numbers[i]) : -1);
  }

  void add_face(long long face) {
    header_.is_binary ? read_binary_face() : read_text_face(face);
    mesh_.add_polygon(path_, face, corners_);
    if (header_.has_coordinates)
      for (const auto& triangle : mesh_.cut)
        for (const int place : triangle)
          mesh_.coordinates.push_back(vertices_.coordinates.row(corners_[std::size_t(place)]).transpose());
  }

  Path path_;
  MeshScanner scan_;
  OffHeader header_;
  OffVertices vertices_;
  bool big_endian_ = true;
  MeshAssembly mesh_;
  std::vector<double> numbers_;
  std::vector<int> corners_;
};

}  // namespace

MeshFile read_off(const Path& path) {
  const std::string text = read_file(path);
  return OffReader(path, text).read();
}

}  // namespace umax
