#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "scenes/presets.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

/// What --set presets=FILE names; throws Error (usage) for other keys.
std::optional<std::filesystem::path> file_of(const Options& options) {
  std::optional<std::filesystem::path> file;
  for (const Override& override : scene_overrides(options)) {
    if (override.key != "presets")
      throw Error(Fault::usage, {.where = "--set " + override.key,
                                 .what = "does not go with umax presets",
                                 .remedy = "it takes --set presets=FILE, a file of materials of your own"});
    file = override.value;
  }
  return file;
}

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.push_back(preset.name);
  return names;
}

int list_presets(const Options& options) {
  const std::vector<Preset> known = presets(file_of(options));
  for (std::size_t i = 0; i < options.inputs.size(); ++i)
    fmt::print("{}{}", i == 0 ? "" : "\n", preset_toml(find_preset(known, options.inputs[i], "umax presets")));
  if (!options.inputs.empty()) return 0;

  std::size_t width = 0;
  for (const Preset& preset : known) width = std::max(width, preset.name.size());
  for (const Preset& preset : known) fmt::print("{:<{}}  {}\n", preset.name, width, preset.description);
  return 0;
}

}  // namespace

Verb presets_verb() {
  return {.name = "presets",
          .usage = "[NAME...]",
          .summary = "lists the materials that scenes can name",
          .details =
              "One line each: name, then a description. With names it prints their keys, ready for a scene's "
              "[body.NAME], and where the numbers come from. --set presets=FILE adds a file of your own.",
          .examples = {"umax presets rubber", "umax run figure --set body.figure.material.preset=gel"},
          .arguments = {.words = preset_names},
          .options = {"--set"},
          .run = list_presets};
}

}  // namespace umax
