#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "scenes/builtin_scenes.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"

namespace umax {
namespace {

int list_scenes(const Options& options) {
  if (!options.inputs.empty())
    throw Error(
        Fault::usage,
        {.what = "umax scenes takes no argument", .value = options.inputs.front(), .remedy = "see umax help scenes"});
  const auto scenes = builtin_scenes();
  std::size_t width = 0;
  for (const BuiltinScene& scene : scenes) width = std::max(width, scene.name.size());
  for (const BuiltinScene& scene : scenes) fmt::print("{:<{}}  {}\n", scene.name, width, scene.description);
  return 0;
}

}  // namespace

Verb scenes_verb() {
  return {.name = "scenes",
          .usage = "",
          .summary = "lists the built-in scenes",
          .details = "One line each: name, then a description.",
          .examples = {},
          .arguments = {},
          .options = {},
          .run = list_scenes};
}

}  // namespace umax
