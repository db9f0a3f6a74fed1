// What the headers of STL files promise, against what follows: their reader accepts truncated files silently.
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <fstream>

#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

[[noreturn]] void refuse_truncated(const Path& path, const std::string& found) {
  refuse_mesh(path, "the mesh file is truncated", found, "copy or export it again");
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
  if (ending == "stl") return check_stl(path);
  return -1;
}

}  // namespace umax
