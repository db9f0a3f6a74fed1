#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "tools/live/server.h"

namespace umax {

// Written by CMake into the build folder from page.html, page.css and the scripts.
extern const std::pair<const char*, const char*> embedded_live_page[];
extern const std::size_t num_embedded_live_page;

namespace fs = std::filesystem;
namespace {

/// The first of these files that there is.
std::string library(const fs::path& folder, const std::vector<std::string>& names) {
  std::error_code error;
  for (const std::string& name : names)
    if (fs::is_regular_file(folder / name, error)) return read_file(folder / name);
  throw Error(Fault::unavailable, {.where = (folder / names.front()).string(),
                                   .what = "is not there; it is a part of three.js, which draws the page of umax live",
                                   .remedy = "install it (apt-get install libjs-three), or name its folder in the "
                                             "environment variable UMAX_THREE"});
}

}  // namespace

std::map<std::string, std::string> page_files() {
  const char* named = std::getenv("UMAX_THREE");
  const fs::path folder = named && *named ? named : "/usr/share/javascript/three";
  std::map<std::string, std::string> files;
  for (std::size_t i = 0; i < num_embedded_live_page; ++i)
    files[embedded_live_page[i].first] = embedded_live_page[i].second;
  files["three.min.js"] = library(folder, {"three.min.js", "build/three.min.js", "three.js"});
  files["OrbitControls.js"] = library(folder, {"examples/js/controls/OrbitControls.js", "OrbitControls.js"});
  files["TransformControls.js"] =
      library(folder, {"examples/js/controls/TransformControls.js", "TransformControls.js"});
  return files;
}

}  // namespace umax
