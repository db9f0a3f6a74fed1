// Materials by name: what `material.preset = "rubber"` stands for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

/// A named material: keys of a body, with where the numbers come from.
struct Preset {
  std::string name;
  std::string description;                                 // one line: what it is
  std::string source;                                      // where the numbers come from
  std::vector<std::pair<std::string, SceneValue>> values;  // by the key's name within the body: "material.young"
};

/// The presets that come with the program, and behind them those of a file of the user's; one of the same name takes
/// the place of ours. Throws Error: not_found, bad_data with file:line for keys that are no material's and values that
/// do not fit.
std::vector<Preset> presets(const std::optional<std::filesystem::path>& file = std::nullopt);

/// The preset of this name. Throws Error (bad_data) that points at `place` and names the nearest one.
const Preset& find_preset(const std::vector<Preset>& presets, const std::string& name, const std::string& place);

/// Puts into every body that names a preset the preset's values for the keys that the body does not give itself: of a
/// group (limit.energy, .density, .stretch) one that is given stands for all. Throws what presets() and find_preset()
/// do.
void expand_presets(SceneDocument& document);

/// Whether a preset may give this key of a body: material, limit, and how light gets into it.
bool is_preset_key(const std::string& name);

/// The preset as lines for a scene's [body.NAME], its source as comments.
std::string preset_toml(const Preset& preset);

}  // namespace umax
