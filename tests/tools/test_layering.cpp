// The rooms' walls: who may include whom, and where each third-party library lives.
#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const std::vector<std::string> rooms{"core", "embedding", "render", "scenes", "tools"};

struct Include {
  std::string file;    // "core/step.h"
  std::string target;  // "render/image.h" or "embree3/rtcore.h"
  bool is_ours = false;
};

std::string room_of(const std::string& path) {
  return path.substr(0, path.find('/'));
}

std::vector<Include> includes_of(const std::string& room) {
  static const std::regex line(R"(^[ \t]*#[ \t]*include[ \t]*[<"]([^>"]+)[>"])", std::regex::multiline);
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / room)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    const std::string text = file_text(entry.path()),
                      file = fs::relative(entry.path(), UMAX_SOURCE_DIR).generic_string();
    for (std::sregex_iterator match(text.begin(), text.end(), line), end; match != end; ++match) {
      const std::string target = (*match)[1];
      const bool ours = std::find(rooms.begin(), rooms.end(), room_of(target)) != rooms.end() &&
                        fs::exists(fs::path(UMAX_SOURCE_DIR) / target);
      includes.push_back({file, target, ours});
    }
  }
  return includes;
}

bool is_standard(const std::string& target) {
  // the C++ library has no dot; the headers of POSIX, the compiler and the C library that we use
  static const std::set<std::string> of_system{
      "fcntl.h",    "unistd.h",       "spawn.h",    "dlfcn.h",    "poll.h",      "sys/file.h", "sys/ioctl.h",
      "sys/mman.h", "sys/resource.h", "sys/stat.h", "sys/wait.h", "immintrin.h", "malloc.h"};
  return target.find_first_of("./") == std::string::npos || of_system.count(target) > 0;
}

/// The library that a third-party header belongs to.
std::string library_of(const std::string& target) {
  static const std::vector<std::pair<std::string, std::string>> prefixes{
      {"Eigen/", "Eigen"},     {"tbb/", "TBB"},
      {"oneapi/", "TBB"},      {"cholmod.h", "CHOLMOD"},
      {"cblas.h", "BLAS"},     {"assimp/", "assimp"},
      {"openvdb/", "OpenVDB"}, {"tiny_obj_loader.h", "tinyobjloader"},
      {"embree3/", "Embree"},  {"embree4/", "Embree"},
      {"GL/", "OSMesa"},       {"Imf", "OpenEXR"},
      {"OpenEXR/", "OpenEXR"}, {"Iex", "OpenEXR"},
      {"png.h", "libpng"},     {"zlib.h", "zlib"},
      {"cairo", "Cairo"},      {"toml++/", "toml++"},
      {"openssl/", "OpenSSL"}, {"CLI/", "CLI11"},
      {"nlohmann/", "json"},   {"pugixml.hpp", "pugixml"},
      {"fmt/", "fmt"},         {"ceres/", "Ceres"}};
  for (const auto& [prefix, library] : prefixes)
    if (target.starts_with(prefix)) return library;
  return "unknown (" + target + ")";
}

const std::map<std::string, std::set<std::string>> rooms_allowed{
    {"core", {"core"}},
    {"embedding", {"core", "embedding"}},
    {"render", {"core", "render"}},
    {"scenes", {"core", "embedding", "render", "scenes"}},
    {"tools", {"core", "embedding", "render", "scenes", "tools"}}};

const std::map<std::string, std::set<std::string>> libraries_allowed{
    {"core", {"Eigen", "TBB", "CHOLMOD", "BLAS"}},
    {"embedding", {"Eigen", "TBB", "assimp", "tinyobjloader", "OpenVDB", "pugixml", "zlib", "fmt"}},
    {"render", {"Eigen", "TBB", "Embree", "OSMesa", "OpenEXR", "libpng", "Cairo", "fmt"}},
    {"scenes", {"Eigen", "toml++", "OpenSSL", "fmt"}},
    {"tools", {"Eigen", "TBB", "CLI11", "json", "Cairo", "Ceres", "fmt"}}};

}  // namespace

TEST_CASE("dependencies between rooms point one way") {
  for (const std::string& room : rooms) {
    const auto includes = includes_of(room);
    CHECK(!includes.empty());
    for (const Include& include : includes) {
      if (!include.is_ours) continue;
      CAPTURE(include.file, include.target);
      CHECK(rooms_allowed.at(room).count(room_of(include.target)) == 1);
    }
  }
}

TEST_CASE("the renderers know nothing of lattices and states") {
  const std::set<std::string> allowed{"core/types.h", "core/error.h", "core/triangle_mesh.h", "core/parallel.h"};
  for (const Include& include : includes_of("render")) {
    if (!include.is_ours || room_of(include.target) != "core") continue;
    CAPTURE(include.file, include.target);
    CHECK(allowed.count(include.target) == 1);
  }
}

TEST_CASE("every library stays in its rooms") {
  for (const std::string& room : rooms)
    for (const Include& include : includes_of(room)) {
      if (include.is_ours || is_standard(include.target)) continue;
      CAPTURE(include.file, include.target);
      CHECK(libraries_allowed.at(room).count(library_of(include.target)) == 1);
    }
}

TEST_CASE("headers show no library but Eigen, so that each stays in its own source file") {
  for (const std::string& room : rooms)
    for (const Include& include : includes_of(room)) {
      if (include.is_ours || is_standard(include.target) || !include.file.ends_with(".h")) continue;
      CAPTURE(include.file, include.target);
      CHECK(library_of(include.target) == "Eigen");
    }
}

TEST_CASE("libraries with large interfaces are included by one source file") {
  std::map<std::string, std::set<std::string>> files;
  for (const std::string& room : rooms)
    for (const Include& include : includes_of(room))
      if (!include.is_ours && !is_standard(include.target)) files[library_of(include.target)].insert(include.file);
  for (const char* library : {"assimp", "tinyobjloader", "Embree", "OSMesa", "toml++", "CLI11", "CHOLMOD", "OpenSSL",
                              "libpng", "zlib", "pugixml", "Ceres"}) {
    CAPTURE(library, files[library]);
    CHECK(files[library].size() <= 1);
  }
  CHECK(files["CLI11"].size() == 1);
  // meshes as level sets, and grids from files
  CHECK(files["OpenVDB"] == std::set<std::string>{"embedding/level_set.cpp", "embedding/vdb_grid.cpp"});
}

TEST_CASE("every header says in its first line what it is for, and is included once") {
  for (const std::string& room : rooms)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / room)) {
      if (entry.path().extension() != ".h") continue;
      CAPTURE(entry.path());
      const std::string text = file_text(entry.path());
      CHECK(text.starts_with("// "));
      CHECK(text.find("#pragma once") != std::string::npos);
    }
}

TEST_CASE("names of tests have no semicolon and do not begin like an option, or ctest would run none") {
  static const std::regex name(R"re(TEST_CASE\(\s*"(-|[^"]*;))re");
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / "tests")) {
    if (entry.path().extension() != ".cpp") continue;
    CAPTURE(entry.path().string());
    CHECK(!std::regex_search(file_text(entry.path()), name));
  }
}
