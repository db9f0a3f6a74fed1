// A scene that a script changes key by key: its text, and the values that were set since.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_file.h"

namespace umax {

class EditableScene {
 public:
  /// Throws what parse_scene() throws.
  explicit EditableScene(SceneText text);

  const Scene& scene() const { return scene_; }

  /// As a --set of the command line; value: TOML. Throws Error (bad_data, not_found) that names the key as a script has it;
  /// the scene is then as before.
  void set(const std::string& key, const std::string& value);

  /// The value of a key, or the table of keys that begin so, as the resolved scene has them. Throws Error (bad_data).
  SceneValue get(const std::string& key) const;

  /// The scene with further values; this one stays as it is. Throws what set() throws.
  Scene with(const std::vector<Override>& more) const;

 private:
  SceneText text_;
  std::vector<Override> overrides_;
  Scene scene_;
};

/// scene["KEY"]: how messages name a key of a script's scene.
std::string key_in_script(const std::string& key);

}  // namespace umax
