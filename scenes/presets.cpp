#include "scenes/presets.h"

#include <algorithm>
#include <sstream>

#include "core/base/nearest_word.h"
#include "scenes/scene_file.h"
#include "scenes/toml_text.h"
#include "scenes/value_kinds.h"

namespace umax {

// Written by CMake into the build folder from presets.toml.
extern const std::pair<const char*, const char*> embedded_presets[];

namespace {

constexpr const char* preset_key = "material.preset";

/// Takes the words that describe a preset out of its table; what remains are keys of a body.
SceneValue::Table take_words(const std::string& name, const SceneValue& table, Preset& preset) {
  const auto* entries = table.as<SceneValue::Table>();
  if (!entries) throw value_error(table, "must be a table of a material's keys", "begin it with [" + name + "]");
  SceneValue::Table keys;
  for (const auto& [key, value] : *entries)
    if (key == "description" || key == "source")
      (key == "source" ? preset.source : preset.description) = TextKind().read(value);
    else
      keys.push_back({key, value});
  return keys;
}

/// Reads the values as a body would, so that a preset is wrong where it stands and not where it is used.
void check_values(const Preset& preset) {
  const SceneSection& section = *find_section("body");
  Scene scene;
  section.add(scene, preset.name);
  for (const auto& [name, value] : preset.values) {
    if (!is_preset_key(name))
      throw value_error(value, "is no key of a material",
                        "a preset has keys of material, limit, look.transmission and look.subsurface only");
    section.find(name)->read(value, scene, 0);
  }
}

Preset read_preset(const std::string& name, const SceneValue& table) {
  Preset preset{.name = name, .description = {}, .source = {}, .values = {}};
  // sorted as a body's keys: the same messages for the same mistakes
  SceneValue body = table, bodies = table, root = table;
  body.data = take_words(name, table, preset);
  bodies.data = SceneValue::Table{{name, body}};
  root.data = SceneValue::Table{{"body", bodies}};
  const SceneDocument document = sort_into_keys(root);
  check_groups(document);
  const DocumentThing& thing = document.at("body").at(name);
  for (const SceneKey& key : find_section("body")->keys)
    if (const auto value = thing.values.find(key.name); value != thing.values.end())
      preset.values.emplace_back(key.name, value->second);
  check_values(preset);
  return preset;
}

void add_presets(std::string_view text, const SourcePlace& place, std::vector<Preset>& all) {
  const SceneValue root = parse_toml(text, place);
  for (const auto& [name, table] : *root.as<SceneValue::Table>()) {
    Preset preset = read_preset(name, table);
    const auto same = std::find_if(all.begin(), all.end(), [&](const Preset& one) { return one.name == preset.name; });
    if (same != all.end())
      *same = std::move(preset);
    else
      all.push_back(std::move(preset));
  }
}

/// Whether the body gives the key, or another of its group, itself.
bool is_given(const DocumentThing& body, const SceneSection& section, const SceneKey& key) {
  return std::any_of(section.keys.begin(), section.keys.end(), [&](const SceneKey& other) {
    const bool stands_for_it = other.name == key.name || (!key.group.empty() && other.group == key.group);
    return stands_for_it && body.values.count(other.name) > 0;
  });
}

void expand(const std::string& body_name, const Preset& preset, DocumentThing& body) {
  const SceneSection& section = *find_section("body");
  const DocumentThing given = body;
  for (const auto& [name, value] : preset.values) {
    if (is_given(given, section, *section.find(name))) continue;
    SceneValue& entry = body.values[name] = value;
    entry.key = section.key_prefix(body_name) + name;
  }
}

std::optional<std::filesystem::path> presets_file(const SceneDocument& document) {
  const auto& values = document.at("").at("").values;
  const auto file = values.find("presets");
  if (file == values.end()) return std::nullopt;
  return ExistingFileKind().read(file->second);
}

}  // namespace

bool is_preset_key(const std::string& name) {
  const auto begins = [&](const char* part) { return name.starts_with(part) && name != preset_key; };
  return begins("material.") || begins("limit.") || begins("look.transmission") || begins("look.subsurface");
}

std::vector<Preset> presets(const std::optional<std::filesystem::path>& file) {
  static const std::vector<Preset> built_in = [] {
    std::vector<Preset> all;
    add_presets(embedded_presets[0].second, {.file = "built-in presets.toml"}, all);
    return all;
  }();
  std::vector<Preset> all = built_in;
  if (file) add_presets(read_scene_text(*file), {.file = file->string(), .folder = file->parent_path()}, all);
  return all;
}

const Preset& find_preset(const std::vector<Preset>& presets, const std::string& name, const std::string& place) {
  std::vector<std::string> names;
  for (const Preset& preset : presets) {
    if (preset.name == name) return preset;
    names.push_back(preset.name);
  }
  throw Error(Fault::bad_data,
              {.where = place,
               .what = "there is no such preset",
               .value = toml_string(name),
               .remedy = "did you mean " + toml_string(nearest_word(name, names)) + "? There are " + list_text(names)});
}

void expand_presets(SceneDocument& document) {
  const std::optional<std::filesystem::path> file = presets_file(document);
  std::vector<Preset> known;
  for (auto& [name, body] : document.at("body")) {
    const auto chosen = body.values.find(preset_key);
    if (chosen == body.values.end()) continue;
    if (known.empty()) known = presets(file);
    const SceneValue value = chosen->second;
    expand(name, find_preset(known, TextKind().read(value), where_text(value.place, value.key)), body);
  }
}

std::string preset_toml(const Preset& preset) {
  std::string text = "# " + preset.name + ": " + preset.description + "\n";
  std::istringstream source(preset.source);
  for (std::string line; std::getline(source, line);) text += "# " + line + "\n";
  for (const auto& [name, value] : preset.values) text += name + " = " + value_text(value) + "\n";
  return text;
}

}  // namespace umax
