// Lines for a scene file that make it a variant.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

/// The settings as TOML, in tables: what the user wrote where it is a quantity or a name, otherwise as the scene, which
/// these settings made, has it.
std::string scene_snippet(const Scene& scene, const std::vector<Override>& settings);

}  // namespace umax
