#include "tools/python/editable_scene.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "scenes/resolved_scene.h"
#include "scenes/toml_text.h"

namespace umax {
namespace {

// A key that was set by a script is no --set of a command line.
Error as_in_script(const Error& error, const std::string& key) {
  ErrorText text = error.text();
  const std::string option = "--set " + key;
  if (text.where.starts_with(option)) text.where = key_in_script(key) + text.where.substr(option.size());
  return Error(error.fault(), text);
}

Scene parse_with(const SceneText& text, const std::vector<Override>& overrides) {
  try {
    return parse_scene(text, overrides);
  } catch (const Error& error) {
    for (const Override& override : overrides)
      if (error.text().where.starts_with("--set " + override.key)) throw as_in_script(error, override.key);
    throw;
  }
}

Error unknown_key(const std::string& key, const std::string& start, const std::string& word,
                  const SceneValue::Table& table) {
  std::vector<std::string> known;
  for (const auto& [name, value] : table) known.push_back(name);
  const std::string remedy = known.empty() ? "" : "did you mean " + start + nearest_word(word, known) + "?";
  return Error(Fault::bad_data,
               {.where = key_in_script(key), .what = "is no key that this scene has", .remedy = remedy});
}

}  // namespace

std::string key_in_script(const std::string& key) {
  return "scene[\"" + key + "\"]";
}

EditableScene::EditableScene(SceneText text) : text_(std::move(text)), scene_(parse_scene(text_)) {}

void EditableScene::set(const std::string& key, const std::string& value) {
  std::vector<Override> overrides = overrides_;
  std::erase_if(overrides, [&](const Override& override) { return override.key == key; });
  overrides.push_back({key, value});
  scene_ = parse_with(text_, overrides);
  overrides_ = std::move(overrides);
}

SceneValue EditableScene::get(const std::string& key) const {
  SceneValue value = parse_toml(resolved_toml(scene_), {.file = text_.file, .folder = text_.folder});
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find('.', begin), key.size());
    const std::string word = key.substr(begin, end - begin);
    const auto* table = value.as<SceneValue::Table>();
    if (!table) throw unknown_key(key, key.substr(0, begin), word, {});
    const auto entry = std::find_if(table->begin(), table->end(), [&](const auto& e) { return e.name == word; });
    if (entry == table->end()) throw unknown_key(key, key.substr(0, begin), word, *table);
    SceneValue inner = entry->value;
    value = std::move(inner);
    begin = end + 1;
  }
  return value;
}

Scene EditableScene::with(const std::vector<Override>& more) const {
  std::vector<Override> overrides = overrides_;
  overrides.insert(overrides.end(), more.begin(), more.end());
  return parse_with(text_, overrides);
}

}  // namespace umax
