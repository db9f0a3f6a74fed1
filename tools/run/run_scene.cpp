#include "tools/run/run_scene.h"

#include "core/base/error.h"

namespace umax {
namespace fs = std::filesystem;

Scene scene_of_run(const fs::path& folder, const std::vector<Override>& overrides) {
  std::error_code error;
  if (!fs::is_directory(folder, error) || !fs::exists(folder / "scene.toml", error))
    throw Error(Fault::not_found, {.where = folder.string(),
                                   .what = "is not the folder of a run",
                                   .remedy = "give a folder that umax run or simulate made"});
  return load_scene((folder / "scene.toml").string(), overrides);
}

}  // namespace umax
