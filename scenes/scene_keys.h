// The one table of scene keys. The reader, "did you mean …", the resolved writer, the page docs/keys.md and
// `umax help scene` all come from it: no key is written down twice.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/scene_value.h"

namespace umax {

/// One key of a section. `index` tells which of the scene's things of that section is meant (0 in plain sections).
struct SceneKey {
  std::string name;           // within the section: "limit.energy"
  std::string type;           // "number [J], > 0 (k)"
  std::string default_value;  // as TOML, or in words where there is none
  std::string meaning = {};
  std::string group = {};                // of a group only one key may stand; a --set of one replaces the others
  std::vector<std::string> resets = {};  // keys of the file that a --set of this one drops
  std::string turns_on = {};             // key of which a --set of this one drops "none" from the file
  bool defines = false;                  // a --set of it may add a new thing to the scene
  bool required = false;

  std::function<void(const SceneValue&, Scene&, std::size_t index)> read;
  std::function<std::optional<std::string>(const Scene&, std::size_t index)> write;  // nothing: does not apply
};

/// [clip], or one thing each: [body.NAME].
struct SceneSection {
  std::string name;  // "clip"; "" for keys above the first table
  std::string within =
      {};  // of a named section whose things are parts of another one's: [body.NAME.pin.PIN]; their names
           // are "NAME.PIN"
  bool named = false;
  std::string meaning = {};
  std::vector<SceneKey> keys = {};  // in the order in which they are read and written
  std::function<std::size_t(Scene&, const std::string& name)> add =
      {};  // named: appends one with defaults, returns its index
  std::function<std::vector<std::string>(const Scene&)> names = {};  // named: of the things there are

  const SceneKey* find(const std::string& key_name) const;
  std::vector<std::string> key_names() const;
  std::string key_prefix(const std::string& thing) const;  // "body.beam."
  std::string header(const std::string& thing) const;      // "body.beam"
};

/// In the order in which the resolved scene is written.
const std::vector<SceneSection>& scene_sections();
const SceneSection* find_section(const std::string& name);

/// The section of that name whose things are parts of the section's things; null: there is none.
const SceneSection* find_inner_section(const SceneSection& section, const std::string& name);

// One builder per group of sections, each in its own file.
SceneSection top_section();
SceneSection clip_section();
SceneSection solver_section();
SceneSection body_section();
SceneSection pin_section();
SceneSection obstacle_section();
SceneSection pair_section();
SceneSection probe_section();
SceneSection camera_section();
SceneSection light_section();
SceneSection render_section();

}  // namespace umax
