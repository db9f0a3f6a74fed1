#include <fmt/format.h>

#include <set>
#include <utility>

#include "core/base/error.h"
#include "scenes/presets.h"
#include "scenes/scene_file.h"
#include "tools/trials/snippet.h"
#include "tools/tune/aim_command.h"
#include "tools/tune/preview.h"
#include "tools/tune/tuning.h"

namespace umax {
namespace {

/// load_scene(), with complaints about a varied value as of --vary.
Scene load_variant(const std::string& scene, const std::vector<Override>& overrides, const SceneVariant& variant) {
  try {
    return load_scene(scene, overrides);
  } catch (const Error& error) {
    ErrorText text = error.text();
    for (const Override& setting : variant.settings)
      if (text.where == "--set " + setting.key) text.where = "--vary " + setting.key;
    throw Error(error.fault(), text);
  }
}

/// Every preset on every body: what --presets asks for.
Variation all_presets(const Scene& scene, const std::vector<Override>& settings) {
  Variation variation;
  for (const BodyDescription& body : scene.bodies) variation.keys.push_back("body." + body.name + ".material.preset");
  std::optional<std::filesystem::path> file;
  for (const Override& setting : settings)
    if (setting.key == "presets") file = setting.value;
  for (const Preset& preset : presets(file)) variation.values.push_back(preset.name);
  return variation;
}

/// The keys that the user speaks of, which a preview leaves alone.
std::vector<std::string> chosen_keys(const std::vector<Override>& settings, const std::vector<Variation>& variations) {
  std::vector<std::string> keys;
  for (const Override& setting : settings) keys.push_back(setting.key);
  for (const Variation& variation : variations) keys.insert(keys.end(), variation.keys.begin(), variation.keys.end());
  return keys;
}

/// What a scene needs to become the variant: what is varied, then what is set for all but how it is drawn.
std::vector<Override> lines_for_scene(const std::vector<Override>& settings, const SceneVariant& variant) {
  std::vector<Override> lines = variant.settings;
  for (const Override& setting : settings)
    if (!setting.key.starts_with("render.") && !setting.key.starts_with("camera.")) lines.push_back(setting);
  return lines;
}

void require_in_step(const TunePlan& plan) {
  const Scene& first = plan.variants.front().scene;
  for (const TuneVariant& one : plan.variants) {
    const bool same = one.scene.clip.frames == first.clip.frames && one.scene.clip.fps == first.clip.fps &&
                      one.scene.render.width == first.render.width && one.scene.render.height == first.render.height;
    if (!same)
      throw Error(Fault::usage, {.where = "--vary " + one.variant.settings.front().key,
                                 .what = "gives variants that cannot be shown in step",
                                 .remedy = "clip.frames, clip.fps and render.size must be the same for all: give "
                                           "them with --set"});
  }
}

}  // namespace

TunePlan plan_tuning(const TuneRequest& request) {
  const std::vector<Override>& settings = request.settings;
  const Scene base = load_scene(request.scene, settings);
  TunePlan plan{.scene_name = base.name, .variations = {}, .variants = {}, .notes = {}};
  if (request.presets) plan.variations.push_back(all_presets(base, settings));
  for (const std::string& text : request.variations) plan.variations.push_back(parse_variation(text));
  const std::vector<SceneVariant> variants = combinations(plan.variations);

  Preview preview;
  if (!request.final) preview = preview_of(base, chosen_keys(settings, plan.variations));
  plan.notes = preview.notes;
  for (const SceneVariant& variant : variants) {
    std::vector<Override> given = settings;
    given.insert(given.end(), variant.settings.begin(), variant.settings.end());
    std::vector<Override> all = preview.settings;
    all.insert(all.end(), given.begin(), given.end());
    TuneVariant one{.variant = variant, .scene = load_variant(request.scene, all, variant), .snippet = {}, .aim = {}};
    one.snippet = scene_snippet(one.scene, lines_for_scene(settings, variant));
    one.aim = aim_command(request.scene, settings, plan.variations, variant);
    plan.variants.push_back(std::move(one));
  }
  require_in_step(plan);
  return plan;
}

}  // namespace umax
