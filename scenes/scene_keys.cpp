#include "scenes/scene_keys.h"

#include <algorithm>

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
  return name.empty() ? "" : header(thing) + ".";
}

std::string SceneSection::header(const std::string& thing) const {
  if (within.empty()) return named ? name + "." + thing : name;
  const std::size_t dot = std::min(thing.find('.'), thing.size());
  return within + "." + thing.substr(0, dot) + "." + name + "." + thing.substr(std::min(dot + 1, thing.size()));
}

const std::vector<SceneSection>& scene_sections() {
  static const std::vector<SceneSection> sections = {
      top_section(),  clip_section(),  solver_section(), body_section(),  pin_section(),    obstacle_section(),
      pair_section(), probe_section(), camera_section(), light_section(), render_section(),
  };
  return sections;
}

const SceneSection* find_section(const std::string& name) {
  for (const SceneSection& section : scene_sections())
    if (section.name == name) return &section;
  return nullptr;
}

const SceneSection* find_inner_section(const SceneSection& section, const std::string& name) {
  const SceneSection* inner = find_section(name);
  return inner && !inner->within.empty() && inner->within == section.name ? inner : nullptr;
}

}  // namespace umax
