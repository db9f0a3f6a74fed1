#include "scenes/resolved_scene.h"

#include "scenes/scene_keys.h"

namespace umax {
namespace {

using Comments = std::map<std::string, std::string>;

void write_keys(const SceneSection& section, const Scene& scene, std::size_t index, const std::string& thing,
                const Comments& comments, std::string& text) {
  for (const SceneKey& key : section.keys) {
    // a scene whose file names no sky gets one with its lights: naming the default would keep both away
    if (scene.wants_lights && section.name == "render" && key.name.starts_with("sky.")) continue;
    if (const auto value = key.write(scene, index)) {
      const auto comment = comments.find(section.key_prefix(thing) + key.name);
      text += key.name + " = " + *value + (comment != comments.end() ? "  # " + comment->second : "") + "\n";
    }
  }
}

/// The table says some defaults with the case that has another: "\"none\"; \"hard\" where a limit is given".
bool is_default(const std::string& value, const SceneKey& key) {
  return value == key.default_value || key.default_value.starts_with(value + "; ");
}

void add_changed(const SceneSection& section, const Scene& scene, std::size_t index, const std::string& thing,
                 std::vector<std::string>& settings) {
  for (const SceneKey& key : section.keys)
    if (const auto value = key.write(scene, index); value && !is_default(*value, key))
      settings.push_back(section.key_prefix(thing) + key.name + " = " + *value);
}

}  // namespace

std::string resolved_toml(const Scene& scene, const Comments& comments) {
  std::string text = "# Every setting of this run, in SI units. `umax run` on this file repeats it.\n";
  for (const SceneSection& section : scene_sections()) {
    if (!section.named) {
      if (!section.name.empty()) text += "\n[" + section.name + "]\n";
      write_keys(section, scene, 0, "", comments, text);
      continue;
    }
    const std::vector<std::string> names = section.names(scene);
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += "\n[" + section.header(names[i]) + "]\n";
      write_keys(section, scene, i, names[i], comments, text);
    }
  }
  return text;
}

std::vector<std::string> changed_settings(const Scene& scene) {
  std::vector<std::string> settings;
  for (const SceneSection& section : scene_sections()) {
    const std::vector<std::string> names = section.named ? section.names(scene) : std::vector<std::string>{""};
    for (std::size_t i = 0; i < names.size(); ++i) add_changed(section, scene, i, names[i], settings);
  }
  return settings;
}

}  // namespace umax
