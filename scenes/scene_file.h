// Reads scenes: TOML files and built-in ones, with --set overrides.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/scene_document.h"

namespace umax {

/// Splits "key=value" of a --set. Throws Error (usage) if there is no = or no key.
Override parse_override(const std::string& text);

/// SCENE of the command line: the path of a .toml file, or the name of a built-in scene. Throws Error: not_found if
/// there is none (with the nearest built-in) or a file that it names is missing, bad_data with file:line, key, value
/// and remedy.
Scene load_scene(const std::string& scene, const std::vector<Override>& overrides = {});

/// The text of a file that should be TOML. Throws Error (not_found, bad_data).
std::string read_scene_text(const std::filesystem::path& path);

/// A scene as text. file: what messages call it; folder: where its relative paths start; name: unless the text has one.
struct SceneText {
  std::string text;
  std::string file = "scene.toml";
  std::filesystem::path folder = std::filesystem::current_path();
  std::string name = "scene";
};
Scene parse_scene(const SceneText& source, const std::vector<Override>& overrides = {});

/// The text that load_scene() parses. Throws Error (not_found, bad_data).
SceneText find_scene(const std::string& scene);

}  // namespace umax
