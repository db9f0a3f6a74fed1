// What the headers of PLY, OFF and STL files promise, against what follows: the readers accept truncated files
// silently.
#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

[[noreturn]] void refuse_truncated(const Path& path, const std::string& found) {
  refuse_mesh(path, "the mesh file is truncated", found, "copy or export it again");
}

// number of further lines that are neither blank nor comments, at most `enough`
long long count_lines(std::istream& in, long long enough) {
  long long count = 0;
  for (std::string line; count < enough && std::getline(in, line);) {
    const std::size_t start = line.find_first_not_of(" \t\r");
    if (start != line.npos && line[start] != '#') ++count;
  }
  return count;
}

int ply_type_size(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "double" || type == "float64") return 8;
  return 4;
}

struct PlyElement {
  std::string name;
  long long count = 0;
  long long least_bytes = 0;  // of one element in a binary file; lists count as empty, faces as triangles
};

long long check_ply(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<PlyElement> elements;
  bool ascii = false, ended = false;
  for (std::string line; std::getline(in, line) && !ended;) {
    std::istringstream words(line);
    std::string key, word;
    words >> key >> word;
    if (key == "format") ascii = word == "ascii";
    if (key == "element") {
      elements.push_back({word, 0, 0});
      words >> elements.back().count;
    }
    if (key == "property" && !elements.empty()) {
      std::string count_type, item_type;
      if (word == "list") words >> count_type >> item_type;
      const bool is_face = elements.back().name == "face";
      elements.back().least_bytes += word != "list"
                                         ? ply_type_size(word)
                                         : ply_type_size(count_type) + (is_face ? 3 * ply_type_size(item_type) : 0);
    }
    ended = key == "end_header";
    if (ended) break;
  }
  if (!ended) refuse_truncated(path, "a PLY header without its end");

  long long num_vertices = -1, lines = 0, bytes = 0;
  for (const PlyElement& element : elements) {
    if (element.name == "vertex") num_vertices = element.count;
    if (element.count < 0)
      refuse_mesh(path, "the PLY header has a negative count", std::to_string(element.count), "export the mesh again");
    lines += element.count;
    bytes += element.count * element.least_bytes;
  }
  if (ascii) {
    const long long found = count_lines(in, lines);
    if (found < lines) refuse_truncated(path, fmt::format("{} of {} lines", found, lines));
  } else {
    const long long found = (long long)(std::filesystem::file_size(path)) - (long long)(in.tellg());
    if (found < bytes) refuse_truncated(path, fmt::format("{} of at least {} bytes", found, bytes));
  }
  return num_vertices;
}

// the reader takes a vertex that does not exist for the last one
void check_off_faces(const Path& path, std::istream& in, long long num_vertices, long long num_faces) {
  long long face = 0;
  for (std::string line; face < num_faces && std::getline(in, line);) {
    const std::size_t start = line.find_first_not_of(" \t\r");
    if (start == line.npos || line[start] == '#') continue;
    const char* at = line.c_str();
    char* end = nullptr;
    const long long num_corners = std::strtoll(at, &end, 10);
    for (long long corner = 0; corner < num_corners; ++corner) {
      const long long v = std::strtoll(at = end, &end, 10);
      if (end == at) refuse_truncated(path, fmt::format("face {} with {} of {} corners", face, corner, num_corners));
      if (v < 0 || v >= num_vertices)
        refuse_mesh(path, fmt::format("face {} names vertex {}, which does not exist", face, v),
                    fmt::format("{} vertices", num_vertices), "the file is damaged: export it again");
    }
    ++face;
  }
  if (face < num_faces) refuse_truncated(path, fmt::format("{} of {} faces", face, num_faces));
}

long long check_off(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  // the counts stand on the first line after the keyword, or on the keyword's own
  std::string text, line;
  while (std::getline(in, line)) {
    line.erase(std::min(line.find('#'), line.size()));
    std::istringstream words(line);
    std::string word;
    while (words >> word)
      if (word.find("OFF") == word.npos) text += word + ' ';
    if (!text.empty()) break;
  }
  long long num_vertices = -1, num_faces = -1;
  std::istringstream(text) >> num_vertices >> num_faces;
  if (num_vertices < 0 || num_faces < 0)
    refuse_mesh(path, "the OFF header has no counts", '"' + text + '"', "export the mesh again");
  const long long found = count_lines(in, num_vertices);
  if (found < num_vertices) refuse_truncated(path, fmt::format("{} of {} vertices", found, num_vertices));
  check_off_faces(path, in, num_vertices, num_faces);
  return num_vertices;
}

long long check_stl(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  const auto size = (long long)(std::filesystem::file_size(path));
  std::string start(std::size_t(std::min(size, 84LL)), '\0');
  in.read(start.data(), std::streamsize(start.size()));

  // a text file says "solid" and then "facet"; many binary ones say "solid" as well
  std::string more(1024, '\0');
  in.read(more.data(), std::streamsize(more.size()));
  more.resize(std::size_t(in.gcount()));
  if (start.rfind("solid", 0) == 0 && (start + more).find("facet") != std::string::npos) {
    in.clear();
    in.seekg(std::max(0LL, size - 1024));
    std::string end((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (end.find("endsolid") == std::string::npos) refuse_truncated(path, "no \"endsolid\"");
    return -1;
  }
  if (size < 84) refuse_truncated(path, fmt::format("{} bytes", size));
  std::uint32_t num_facets = 0;
  std::memcpy(&num_facets, start.data() + 80, sizeof num_facets);
  const long long promised = 84 + 50LL * num_facets;
  if (size < promised) refuse_truncated(path, fmt::format("{} of {} bytes", size, promised));
  return 3LL * num_facets;
}

}  // namespace

long long check_promised_size(const Path& path, const std::string& ending) {
  if (ending == "ply") return check_ply(path);
  if (ending == "off") return check_off(path);
  if (ending == "stl") return check_stl(path);
  return -1;
}

}  // namespace umax
