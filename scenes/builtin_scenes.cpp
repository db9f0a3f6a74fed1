#include "scenes/builtin_scenes.h"

#include <cassert>
#include <utility>

#include "scenes/toml_text.h"

namespace umax {

// Written by CMake into the build folder from the .toml files.
extern const std::pair<const char*, const char*> embedded_scenes[];
extern const std::size_t num_embedded_scenes;

namespace {

std::string name_of(std::size_t index) {
  const std::string file = embedded_scenes[index].first;
  return file.substr(0, file.rfind('.'));
}

BuiltinScene describe(std::size_t index) {
  BuiltinScene scene{name_of(index), "", embedded_scenes[index].second};
  const SceneValue root = parse_toml(scene.text, {.file = "built-in " + scene.name + ".toml"});
  for (const auto& [key, value] : *root.as<SceneValue::Table>())
    if (const auto* description = value.as<std::string>(); description && key == "description")
      scene.description = *description;
  return scene;
}

}  // namespace

std::vector<BuiltinScene> builtin_scenes() {
  std::vector<BuiltinScene> scenes;
  for (std::size_t i = 0; i < num_embedded_scenes; ++i) scenes.push_back(describe(i));
  return scenes;
}

std::optional<BuiltinScene> find_builtin_scene(const std::string& name) {
  for (std::size_t i = 0; i < num_embedded_scenes; ++i)
    if (name == name_of(i)) return describe(i);
  return std::nullopt;
}

}  // namespace umax
