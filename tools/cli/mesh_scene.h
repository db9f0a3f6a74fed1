// Scenes for meshes that come without one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "tools/cli/options.h"

namespace umax {

/// A scene for a mesh: sensible cage, stiffness in proportion to its height, a limit on stretch, a studio around it.
/// drop_height [-]: share of its height at which it starts above the ground. Throws Error (bad_data) for meshes under
/// 1 cm or over 20 m, naming the options that mend it.
Scene scene_of_mesh(const std::filesystem::path& path, double drop_height, const Options& options);

/// The same of several that fall together: `count` bodies in all, the meshes taken in turn. They start in layers above
/// each other, so far apart that they cannot overlap however they are turned; each mesh stands upright the first time.
/// Bodies are named after the files. Throws Error (usage) where there are fewer bodies than meshes.
Scene scene_of_meshes(const std::vector<std::filesystem::path>& paths, int count, const Options& options);

}  // namespace umax
