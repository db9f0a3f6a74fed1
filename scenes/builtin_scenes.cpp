#include "scenes/builtin_scenes.h"

#include <cassert>
#include <utility>

#include "scenes/toml_text.h"

namespace umax {

// Written by CMake into the build folder from the .toml files.
extern const std::pair<const char*, const char*> embedded_scenes[];
extern const std::size_t num_embedded_scenes;

namespace {

BuiltinScene describe(const std::string& name, std::string_view text) {
  BuiltinScene scene{name, "", text};
  const SceneValue root = parse_toml(text, {.file = "built-in " + name + ".toml"});
  for (const auto& [key, value] : *root.as<SceneValue::Table>())
    if (const auto* description = value.as<std::string>(); description && key == "description")
      scene.description = *description;
  return scene;
}

}  // namespace

std::vector<BuiltinScene> builtin_scenes() {
  std::vector<BuiltinScene> scenes;
  for (std::size_t i = 0; i < num_embedded_scenes; ++i)
    scenes.push_back(describe(embedded_scenes[i].first, embedded_scenes[i].second));
  return scenes;
}

std::optional<BuiltinScene> find_builtin_scene(const std::string& name) {
  for (std::size_t i = 0; i < num_embedded_scenes; ++i)
    if (name == embedded_scenes[i].first) return describe(name, embedded_scenes[i].second);
  return std::nullopt;
}

}  // namespace umax
