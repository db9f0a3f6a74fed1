// The rooms' walls: who may include whom, and where each third-party library lives.
#include <algorithm>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const std::vector<std::string> tops{"core", "embedding", "render", "scenes", "tools"};

/// The plan of the house: each room (a folder with a library of its own) and the rooms that stand directly below it. A
/// file may include those and what stands below them in turn, but for the doors that shut_doors names.
const std::map<std::string, std::vector<std::string>> rooms_below{
    {"core/base", {}},
    {"core/files", {"core/base"}},
    {"core/element", {"core/base"}},
    {"core/model", {"core/element"}},
    {"core/contact", {"core/model"}},
    {"core/linear/bricks", {"core/element"}},
    {"core/linear/multigrid", {"core/linear/bricks"}},
    {"core/linear/direct", {"core/model"}},
    {"core/linear/saddle", {"core/linear/multigrid", "core/linear/direct"}},
    {"core/problem", {"core/contact"}},
    {"core/step", {"core/problem", "core/linear/saddle"}},

    {"embedding/surface", {"core/model"}},
    {"embedding/scanning", {"core/base", "core/files"}},
    {"embedding/caches", {"core/base", "core/files"}},
    {"embedding/cameras", {"embedding/scanning"}},
    {"embedding/hex_files", {"embedding/scanning", "embedding/surface"}},
    {"embedding/mesh_record", {"embedding/scanning"}},
    {"embedding/foreign_files", {"embedding/mesh_record", "embedding/surface"}},
    {"embedding/mesh_files", {"embedding/hex_files", "embedding/mesh_record"}},
    {"embedding/cage", {"embedding/surface"}},
    {"embedding/figure", {"embedding/surface"}},
    {"embedding", {"embedding/cage"}},
    {"embedding/maps", {"embedding", "embedding/scanning"}},

    {"render/image", {"core/base", "core/files"}},
    {"render/scene", {"render/image"}},
    {"render/annotation", {"render/scene"}},
    {"render/trace", {"render/scene"}},
    {"render/raster", {"render/scene"}},

    {"scenes",
     {"core/problem", "core/files", "embedding/caches", "embedding/hex_files", "embedding/maps", "render/scene"}},

    {"tools/system", {"core/base", "core/files"}},
    {"tools/import", {"embedding/foreign_files"}},
    {"tools/setup",
     {"scenes", "core/step", "embedding/mesh_files", "embedding/figure", "embedding/maps", "embedding/cameras"}},
    {"tools/pictures", {"tools/setup", "tools/system", "render/annotation", "render/trace", "render/raster"}},
    {"tools/exchange", {"tools/pictures", "embedding/caches"}},
    {"tools/run", {"tools/exchange"}},
    {"tools/pages", {"render/annotation"}},
    {"tools/fit", {"tools/pictures"}},
    {"tools/live", {"tools/run"}},
    {"tools/trials", {"tools/run"}},
    {"tools/tune", {"tools/trials", "tools/pages"}},
    {"tools/aim", {"tools/trials", "tools/pages"}},
    {"tools/farm", {"tools/trials"}},
    {"tools/reproduce", {"tools/run", "tools/pages"}},
    {"tools/cli", {"tools/live", "tools/tune", "tools/aim", "tools/farm", "tools/reproduce", "tools/fit"}},
    {"tools/python", {"tools/run", "tools/fit", "tools/pages"}},
    {"tools/benchmarks", {"tools/live", "tools/run", "tools/reproduce", "embedding/foreign_files"}}};

/// Rooms that stand below and yet are not entered from a room: the program speaks to the solver by model, step options
/// and step.
const std::vector<std::pair<std::string, std::string>> shut_doors{
    {"scenes", "core/contact"},         {"scenes", "core/linear"},           {"embedding", "core/contact"},
    {"tools/system", "core/element"},   {"tools/setup", "core/contact"},     {"tools/setup", "core/linear"},
    {"tools/pictures", "core/contact"}, {"tools/pictures", "core/linear"},   {"tools/exchange", "core/contact"},
    {"tools/exchange", "core/element"}, {"tools/exchange", "core/linear"},   {"tools/run", "core/contact"},
    {"tools/run", "core/element"},      {"tools/run", "core/linear"},        {"tools/fit", "core/contact"},
    {"tools/fit", "core/linear"},       {"tools/tune", "core/contact"},      {"tools/tune", "core/linear"},
    {"tools/tune", "core/element"},     {"tools/reproduce", "core/contact"}, {"tools/reproduce", "core/linear"},
    {"tools/live", "core/contact"},     {"tools/live", "core/element"},      {"tools/live", "core/linear"},
    {"tools/trials", "core/contact"},   {"tools/trials", "core/linear"},     {"tools/trials", "core/element"},
    {"tools/aim", "core/contact"},      {"tools/aim", "core/linear"},        {"tools/aim", "core/element"},
    {"tools/farm", "core/contact"},     {"tools/farm", "core/linear"},       {"tools/farm", "core/element"},
    {"tools/cli", "core/contact"},      {"tools/cli", "core/linear"},        {"tools/python", "core/contact"},
    {"tools/python", "core/linear"},    {"tools/python", "core/element"}};

/// What tests and benchmarks share, outside of the house: of its rooms only benchmarks may include it.
const std::string shared_with_tests = "tests/support";

struct Include {
  std::string file;    // "core/step/step.h"
  std::string target;  // "render/image/image.h" or "embree3/rtcore.h"
  bool is_ours = false;
};

std::string room_of(const std::string& path) {
  const std::string folder = path.substr(0, path.rfind('/'));
  return path.find('/') == std::string::npos ? "" : folder;
}

std::string top_of(const std::string& path) {
  return path.substr(0, path.find('/'));
}

/// The room and all that stands below it.
std::set<std::string> reachable_from(const std::string& room) {
  std::set<std::string> found{room};
  for (const std::string& below : rooms_below.at(room)) found.merge(reachable_from(below));
  return found;
}

bool is_shut(const std::string& room, const std::string& target) {
  return std::any_of(shut_doors.begin(), shut_doors.end(), [&](const auto& door) {
    return door.first == room && (target == door.second || target.starts_with(door.second + "/"));
  });
}

/// Whether a file of the room may include a header of the target room.
bool may_enter(const std::string& room, const std::string& target) {
  if (target == shared_with_tests) return room == "tools/benchmarks";
  return room == target || (reachable_from(room).count(target) == 1 && !is_shut(room, target));
}

std::vector<Include> includes_of(const std::string& top) {
  static const std::regex line(R"(^[ \t]*#[ \t]*include[ \t]*[<"]([^>"]+)[>"])", std::regex::multiline);
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / top)) {
    const std::string extension = entry.path().extension().string();
    if (extension != ".h" && extension != ".cpp") continue;
    const std::string text = file_text(entry.path()),
                      file = fs::relative(entry.path(), UMAX_SOURCE_DIR).generic_string();
    for (std::sregex_iterator match(text.begin(), text.end(), line), end; match != end; ++match) {
      const std::string target = (*match)[1];
      const bool ours =
          (std::find(tops.begin(), tops.end(), top_of(target)) != tops.end() || room_of(target) == shared_with_tests) &&
          fs::exists(fs::path(UMAX_SOURCE_DIR) / target);
      includes.push_back({file, target, ours});
    }
  }
  return includes;
}

bool is_standard(const std::string& target) {
  // the C++ library has no dot; the headers of POSIX, the compiler and the C library that we use
  static const std::set<std::string> of_system{
      "fcntl.h",    "unistd.h",    "spawn.h",      "dlfcn.h",        "poll.h",     "sys/file.h", "sys/ioctl.h",
      "sys/mman.h", "sys/prctl.h", "sys/random.h", "sys/resource.h", "sys/stat.h", "sys/time.h", "sys/utsname.h",
      "sys/vfs.h",  "sys/wait.h",  "sched.h",      "immintrin.h",    "malloc.h"};
  return target.find_first_of("./") == std::string::npos || of_system.count(target) > 0;
}

/// The library that a third-party header belongs to.
std::string library_of(const std::string& target) {
  static const std::vector<std::pair<std::string, std::string>> prefixes{
      {"Eigen/", "Eigen"},      {"tbb/", "TBB"},
      {"oneapi/", "TBB"},       {"cholmod.h", "CHOLMOD"},
      {"cblas.h", "BLAS"},      {"assimp/", "assimp"},
      {"openvdb/", "OpenVDB"},  {"tiny_obj_loader.h", "tinyobjloader"},
      {"embree3/", "Embree"},   {"embree4/", "Embree"},
      {"GL/", "OSMesa"},        {"Imf", "OpenEXR"},
      {"OpenEXR/", "OpenEXR"},  {"Iex", "OpenEXR"},
      {"png.h", "libpng"},      {"zlib.h", "zlib"},
      {"jpeglib.h", "libjpeg"}, {"jerror.h", "libjpeg"},
      {"cairo", "Cairo"},       {"toml++/", "toml++"},
      {"openssl/", "OpenSSL"},  {"CLI/", "CLI11"},
      {"nlohmann/", "json"},    {"pugixml.hpp", "pugixml"},
      {"fmt/", "fmt"},          {"draco/", "Draco"},
      {"ceres/", "Ceres"},      {"boost/", "Boost"},
      {"pybind11/", "pybind11"}};
  for (const auto& [prefix, library] : prefixes)
    if (target.starts_with(prefix)) return library;
  return "unknown (" + target + ")";
}

/// The rooms whose source files include a library; all but Eigen stay out of headers.
const std::map<std::string, std::set<std::string>> rooms_of_library{
    {"Boost", {"tools/live"}},
    {"CHOLMOD", {"core/linear/direct"}},
    {"CLI11", {"tools/cli"}},
    {"Cairo", {"render/annotation", "tools/pictures"}},
    {"Ceres", {"tools/fit"}},
    {"Embree", {"render/trace"}},
    {"OSMesa", {"render/raster"}},
    {"OpenEXR", {"render/image"}},
    {"OpenSSL", {"core/files"}},
    {"OpenVDB", {"embedding/maps", "embedding/surface"}},
    {"TBB",
     {"core/base", "embedding/cage", "embedding/figure", "embedding/surface", "render/image", "render/raster",
      "tools/system"}},
    {"assimp", {"embedding/foreign_files"}},
    {"Draco", {"embedding/foreign_files"}},
    {"json",
     {"embedding/cameras", "embedding/foreign_files", "tools/aim", "tools/benchmarks", "tools/cli", "tools/farm",
      "tools/live", "tools/reproduce", "tools/run", "tools/trials", "tools/tune"}},
    {"libjpeg", {"render/image"}},
    {"libpng", {"render/image"}},
    {"pybind11", {"tools/python"}},
    {"pugixml", {"embedding/hex_files"}},
    {"tinyobjloader", {"embedding/mesh_files"}},
    {"toml++", {"scenes"}},
    {"zlib", {"embedding/scanning"}}};

}  // namespace

TEST_CASE("every folder with code is a room of the plan, and has a library of its own") {
  std::set<std::string> found;
  for (const std::string& top : tops)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / top))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        found.insert(room_of(fs::relative(entry.path(), UMAX_SOURCE_DIR).generic_string()));
  std::set<std::string> planned;
  for (const auto& [room, below] : rooms_below) planned.insert(room);
  CHECK(found == planned);
  for (const std::string& room : planned) {
    CAPTURE(room);
    CHECK(fs::exists(fs::path(UMAX_SOURCE_DIR) / room / "CMakeLists.txt"));
  }
}

TEST_CASE("the plan has no circles, and core no more than six floors") {
  const std::function<int(const std::string&)> floor_of = [&](const std::string& room) {
    int floor = 1;
    for (const std::string& below : rooms_below.at(room)) floor = std::max(floor, 1 + floor_of(below));
    return floor;
  };
  CHECK(floor_of("core/step") <= 6);
  CHECK(floor_of("tools/cli") > floor_of("core/step"));
}

TEST_CASE("rooms include only what the plan puts below them") {
  int num_checked = 0;
  for (const std::string& top : tops)
    for (const Include& include : includes_of(top)) {
      if (!include.is_ours) continue;
      CAPTURE(include.file, include.target);
      CHECK(may_enter(room_of(include.file), room_of(include.target)));
      ++num_checked;
    }
  CHECK(num_checked > 1000);
}

TEST_CASE("a wrong include would be seen") {
  CHECK(!may_enter("core/element", "core/step"));           // upwards
  CHECK(!may_enter("core/contact", "core/linear/direct"));  // next door
  CHECK(!may_enter("core/step", "core/files"));             // the physics reads and writes no files
  CHECK(!may_enter("render/trace", "core/model"));          // renderers know nothing of lattices and states
  CHECK(!may_enter("tools/run", "tools/cli"));              // nothing knows the command line
  CHECK(!may_enter("tools/run", "core/linear/saddle"));     // through a shut door
  CHECK(!may_enter("tools/run", "tests/support"));          // a tool that tests would be part of
  CHECK(may_enter("tools/benchmarks", "tests/support"));
  CHECK(may_enter("core/step", "core/base"));
  CHECK(may_enter("tools/cli", "scenes"));
}

TEST_CASE("the physics includes no file access") {
  for (const auto& [room, below] : rooms_below)
    if (room.starts_with("core/") && room != "core/files") CHECK(reachable_from(room).count("core/files") == 0);
}

TEST_CASE("every library stays in its rooms") {
  for (const std::string& top : tops)
    for (const Include& include : includes_of(top)) {
      if (include.is_ours || is_standard(include.target)) continue;
      const std::string library = library_of(include.target);
      if (library == "Eigen" || library == "fmt") continue;  // everywhere: matrices; text, in source files
      CAPTURE(include.file, include.target);
      REQUIRE(rooms_of_library.count(library) == 1);
      CHECK(rooms_of_library.at(library).count(room_of(include.file)) == 1);
    }
}

TEST_CASE("headers show no library but Eigen, so that each stays in its own source file") {
  for (const std::string& top : tops)
    for (const Include& include : includes_of(top)) {
      if (include.is_ours || is_standard(include.target) || !include.file.ends_with(".h")) continue;
      CAPTURE(include.file, include.target);
      CHECK(library_of(include.target) == "Eigen");
    }
}

TEST_CASE("libraries with large interfaces are included by one source file") {
  std::map<std::string, std::set<std::string>> files;
  for (const std::string& top : tops)
    for (const Include& include : includes_of(top))
      if (!include.is_ours && !is_standard(include.target)) files[library_of(include.target)].insert(include.file);
  for (const char* library : {"Draco", "libjpeg", "tinyobjloader", "Embree", "OSMesa", "toml++", "CLI11", "CHOLMOD",
                              "OpenSSL", "libpng", "zlib", "pugixml", "Ceres", "Boost"}) {
    CAPTURE(library, files[library]);
    CHECK(files[library].size() <= 1);
  }
  CHECK(files["CLI11"].size() == 1);
  // shapes and materials
  CHECK(files["assimp"] == std::set<std::string>{"embedding/foreign_files/foreign_file.cpp",
                                                 "embedding/foreign_files/foreign_material.cpp"});
  // meshes as level sets, and grids from files
  CHECK(files["OpenVDB"] == std::set<std::string>{"embedding/surface/level_set.cpp", "embedding/maps/vdb_grid.cpp"});
}

TEST_CASE("every header says in its first line what it is for, and is included once") {
  for (const std::string& top : tops)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / top)) {
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
