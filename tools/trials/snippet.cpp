#include "tools/trials/snippet.h"

#include <algorithm>
#include <utility>

namespace umax {
namespace {

/// Where a key stands: its section, table header ("" above the first table) and name in it.
struct Place {
  const SceneSection* section = nullptr;
  std::string thing, header, name;
};

/// The place where the dot stands that ends the word that begins at `begin`, or the text's end.
std::size_t end_of_word(const std::string& key, std::size_t begin) {
  return std::min(key.find('.', begin), key.size());
}

/// "body.NAME.pin.PIN.stiffness": a part of a thing, which has a table of its own.
void enter_inner_section(const std::string& key, Place& place) {
  const std::size_t begin = place.header.size() + 1, dot = end_of_word(key, begin), end = end_of_word(key, dot + 1);
  const SceneSection* inner =
      end < key.size() ? find_inner_section(*place.section, key.substr(begin, dot - begin)) : nullptr;
  if (!inner) return;
  place.section = inner;
  place.thing += "." + key.substr(dot + 1, end - dot - 1);
  place.header = key.substr(0, end);
  place.name = key.substr(end + 1);
}

Place place_of(const std::string& key) {
  Place place;
  const std::size_t dot = key.find('.');
  place.section = find_section(dot == std::string::npos ? "" : key.substr(0, dot));
  if (dot == std::string::npos || !place.section) {
    place.name = key;
    return place;
  }
  const std::size_t end = place.section->named ? end_of_word(key, dot + 1) : dot;
  place.header = key.substr(0, end);
  place.name = end < key.size() ? key.substr(end + 1) : "";
  if (!place.section->named) return place;
  place.thing = key.substr(dot + 1, end - dot - 1);
  enter_inner_section(key, place);
  return place;
}

std::optional<std::string> value_at(const Scene& scene, const Place& place) {
  std::size_t index = 0;
  if (place.section->named) {
    const std::vector<std::string> names = place.section->names(scene);
    index = std::size_t(std::find(names.begin(), names.end(), place.thing) - names.begin());
    if (index == names.size()) return std::nullopt;
  }
  const SceneKey* key = place.section->find(place.name);
  return key ? key->write(scene, index) : std::nullopt;
}

/// "5 %" and "gel" stay what they are; lists, numbers and paths are the scene's.
std::string value_of(const Scene& scene, const Override& setting, const Place& place) {
  std::string quoted = toml_string(setting.value);
  const bool is_quantity = setting.value.find_first_of("[{\"'") == std::string::npos &&
                           setting.value.find_first_of("0123456789") < 2 &&
                           setting.value.find_first_not_of("+-.0123456789eE") != std::string::npos;
  // presets have been expanded, and are written by name
  return is_quantity ? quoted : value_at(scene, place).value_or(quoted);
}

}  // namespace

std::string scene_snippet(const Scene& scene, const std::vector<Override>& settings) {
  std::vector<std::pair<std::string, std::string>> tables;  // header, lines
  for (const Override& setting : settings) {
    const Place place = place_of(setting.key);
    auto table = std::find_if(tables.begin(), tables.end(), [&](const auto& one) { return one.first == place.header; });
    if (table == tables.end()) table = tables.insert(tables.end(), {place.header, ""});
    table->second += place.name + " = " + value_of(scene, setting, place) + "\n";
  }
  // keys above the first table can stand nowhere else
  std::stable_partition(tables.begin(), tables.end(), [](const auto& table) { return table.first.empty(); });
  std::string text;
  for (const auto& [header, lines] : tables) {
    if (!text.empty()) text += '\n';
    if (!header.empty()) text.append("[").append(header).append("]\n");
    text += lines;
  }
  return text;
}

std::optional<std::string> value_in_scene(const Scene& scene, const std::string& key) {
  const Place place = place_of(key);
  return place.section ? value_at(scene, place) : std::nullopt;
}

}  // namespace umax
