#include "scenes/scene_file.h"

#include "core/base/nearest_word.h"
#include "core/base/trimmed.h"
#include "core/files/read_file.h"
#include "scenes/builtin_scenes.h"
#include "scenes/presets.h"
#include "scenes/scene_checks.h"
#include "scenes/toml_text.h"

namespace umax {
namespace {

namespace fs = std::filesystem;

void read_values(const SceneSection& section, const DocumentThing& thing, Scene& scene, std::size_t index) {
  for (const SceneKey& key : section.keys) {
    const auto value = thing.values.find(key.name);
    if (value != thing.values.end()) key.read(value->second, scene, index);
  }
}

Scene read_document(const SceneDocument& document, const std::string& name) {
  Scene scene;
  scene.name = name;
  for (const SceneSection& section : scene_sections())
    for (const auto& [thing_name, thing] : document.at(section.name))
      read_values(section, thing, scene, section.named ? section.add(scene, thing_name) : 0);
  complete_and_check(scene, document);
  return scene;
}

bool names_a_file(const std::string& scene) {
  std::error_code failed;
  return scene.find('/') != std::string::npos || fs::path(scene).extension() == ".toml" ||
         fs::is_regular_file(scene, failed);
}

}  // namespace

std::string read_scene_text(const fs::path& path) {
  constexpr std::uintmax_t largest = 64 << 20;
  std::error_code failed;
  if (fs::is_directory(path, failed))
    throw Error(
        Fault::bad_data,
        {.where = path.string(), .what = "is a folder, not a scene file", .remedy = "give the .toml file in it"});
  if (!fs::exists(path, failed))
    throw Error(Fault::not_found, {.where = path.string(),
                                   .what = "no such scene file",
                                   .remedy = "check the path; `umax scenes` lists the built-in scenes"});
  if (fs::file_size(path, failed) > largest && !failed)
    throw Error(Fault::bad_data,
                {.where = path.string(), .what = "is too large for a scene file", .remedy = "give a .toml file"});
  if (!is_readable(path))
    throw Error(Fault::not_found,
                {.where = path.string(), .what = "cannot be read", .remedy = "check its permissions"});
  return read_file(path);
}

namespace {

/// What is around the bodies: the sky, or the backdrop before it.
bool names_sky(const SceneDocument& document) {
  const auto render = document.find("render");
  if (render == document.end()) return false;
  const auto is_of_sky = [](const auto& entry) { return entry.first.starts_with("sky") || entry.first == "backdrop"; };
  const auto& values = render->second.begin()->second.values;
  return !render->second.empty() && std::any_of(values.begin(), values.end(), is_of_sky);
}

}  // namespace

Override parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || trimmed(text.substr(0, equals)).empty())
    throw Error(Fault::usage, {.where = "--set",
                               .what = "needs key=value",
                               .value = text,
                               .remedy = "write for example --set clip.frames=60"});
  return {std::string(trimmed(text.substr(0, equals))), std::string(trimmed(text.substr(equals + 1)))};
}

Scene parse_scene(const SceneText& source, const std::vector<Override>& overrides) {
  SceneDocument document = sort_into_keys(parse_toml(source.text, {.file = source.file, .folder = source.folder}));
  check_groups(document);
  apply_overrides(document, overrides, fs::current_path());
  check_groups(document);
  expand_presets(document);
  Scene scene = read_document(document, source.name);
  scene.wants_lights = scene.lights.empty() && !names_sky(document);
  return scene;
}

Scene load_scene(const std::string& scene, const std::vector<Override>& overrides) {
  return parse_scene(find_scene(scene), overrides);
}

SceneText find_scene(const std::string& scene) {
  if (const auto builtin = find_builtin_scene(scene))
    return {.text = std::string(builtin->text), .file = "built-in " + scene + ".toml", .name = scene};
  if (names_a_file(scene)) {
    const fs::path path = scene;
    return {.text = read_scene_text(path),
            .file = scene,
            .folder = fs::absolute(path).parent_path(),
            .name = path.stem().string()};
  }
  std::vector<std::string> names;
  for (const BuiltinScene& builtin : builtin_scenes()) names.push_back(builtin.name);
  throw Error(Fault::not_found, {.where = scene,
                                 .what = "there is no such built-in scene",
                                 .remedy = "did you mean " + nearest_word(scene, names) +
                                           "? `umax scenes` lists them; files end in .toml"});
}

}  // namespace umax
