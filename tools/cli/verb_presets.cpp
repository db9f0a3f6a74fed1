#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "scenes/presets.h"
#include "tools/cli/verbs.h"
#include "tools/run/job.h"

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

}  // namespace

int verb_presets(const Options& options) {
  const std::vector<Preset> known = presets(file_of(options));
  for (std::size_t i = 0; i < options.inputs.size(); ++i)
    fmt::print("{}{}", i == 0 ? "" : "\n", preset_toml(find_preset(known, options.inputs[i], "umax presets")));
  if (!options.inputs.empty()) return 0;

  std::size_t width = 0;
  for (const Preset& preset : known) width = std::max(width, preset.name.size());
  for (const Preset& preset : known) fmt::print("{:<{}}  {}\n", preset.name, width, preset.description);
  return 0;
}

}  // namespace umax
