// Lines for a scene file that give it other values, and the values that a scene has.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

/// The settings as TOML, in tables: what the user wrote where it is a quantity or a name, otherwise as the scene, which
/// these settings made, has it.
std::string scene_snippet(const Scene& scene, const std::vector<Override>& settings);

/// The value of a key as TOML, as the resolved scene has it: "0.2". Nothing where the key does not apply to the scene,
/// as limit.stretch to a body whose limit is an energy, or does not exist.
std::optional<std::string> value_in_scene(const Scene& scene, const std::string& key);

}  // namespace umax
