#include "tools/tune/snippet.h"

#include <algorithm>
#include <utility>

namespace umax {
namespace {

/// Where a key stands: its section, table header ("" above the first table) and name in it.
struct Place {
  const SceneSection* section = nullptr;
  std::string thing, header, name;
};

Place place_of(const std::string& key) {
  Place place;
  const std::size_t dot = key.find('.');
  place.section = find_section(dot == std::string::npos ? "" : key.substr(0, dot));
  if (dot == std::string::npos) {
    place.name = key;
    return place;
  }
  const std::size_t end = place.section->named ? key.find('.', dot + 1) : dot;
  place.header = key.substr(0, end);
  place.name = key.substr(end + 1);
  if (place.section->named) place.thing = key.substr(dot + 1, end - dot - 1);
  return place;
}

/// "5 %" and "gel" stay what they are; lists, numbers and paths are the scene's.
std::string value_of(const Scene& scene, const Override& setting, const Place& place) {
  std::string quoted = toml_string(setting.value);
  const bool is_quantity = setting.value.find_first_of("[{\"'") == std::string::npos &&
                           setting.value.find_first_of("0123456789") < 2 &&
                           setting.value.find_first_not_of("+-.0123456789eE") != std::string::npos;
  if (is_quantity) return quoted;
  std::size_t index = 0;
  if (place.section->named) {
    const std::vector<std::string> names = place.section->names(scene);
    index = std::size_t(std::find(names.begin(), names.end(), place.thing) - names.begin());
  }
  // presets have been expanded, and are written by name
  return place.section->find(place.name)->write(scene, index).value_or(quoted);
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

}  // namespace umax
