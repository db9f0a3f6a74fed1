#include "scenes/scene_keys.h"

namespace umax {

const SceneKey* SceneSection::find(const std::string& key_name) const {
  for (const SceneKey& key : keys)
    if (key.name == key_name) return &key;
  return nullptr;
}

std::vector<std::string> SceneSection::key_names() const {
  std::vector<std::string> result;
  for (const SceneKey& key : keys) result.push_back(key.name);
  return result;
}

std::string SceneSection::key_prefix(const std::string& thing) const {
  if (name.empty()) return "";
  return named ? name + "." + thing + "." : name + ".";
}

const std::vector<SceneSection>& scene_sections() {
  static const std::vector<SceneSection> sections = {
      top_section(),  clip_section(),  solver_section(), body_section(),  obstacle_section(),
      pair_section(), probe_section(), camera_section(), light_section(), render_section(),
  };
  return sections;
}

const SceneSection* find_section(const std::string& name) {
  for (const SceneSection& section : scene_sections())
    if (section.name == name) return &section;
  return nullptr;
}

}  // namespace umax
