// The scene that a run was made with.
#pragma once

#include <filesystem>
#include <vector>

#include "scenes/scene_file.h"

namespace umax {

/// The scene that a run's folder was made with. Throws Error (not_found) when the folder is no run's.
Scene scene_of_run(const std::filesystem::path& folder, const std::vector<Override>& overrides);

}  // namespace umax
