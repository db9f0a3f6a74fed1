// What a verb's argument is: a run's folder, a mesh, or a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene_file.h"
#include "tools/cli/options.h"
#include "tools/run/run_scene.h"

namespace umax {

enum class InputKind { run, mesh, scene };

/// Names of the built-in scenes.
std::vector<std::string> scene_names();

/// A folder is a run, a name that ends as meshes do is a mesh, everything else a scene.
InputKind kind_of_input(const std::string& input);

}  // namespace umax
