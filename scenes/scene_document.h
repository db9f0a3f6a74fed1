// A scene file between its text and its values: every entry sorted under its key, with overrides applied.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/scene_keys.h"

namespace umax {

/// A --set of the command line.
struct Override {
  std::string key, value;
};

/// The values that are given for one thing, or one plain section.
struct DocumentThing {
  SourcePlace place;                         // of its table
  std::map<std::string, SceneValue> values;  // by the key's name within the section
};

/// By section name, then by the thing's name ("" in plain sections). Ordered, so that no result hangs on a file's
/// order.
using SceneDocument = std::map<std::string, std::map<std::string, DocumentThing>>;

/// Sorts a scene file's root table. Throws Error (bad_data) for keys that are not in the table, with the nearest one.
SceneDocument sort_into_keys(const SceneValue& root);

/// Applies --set options in order; relative paths start at `folder`.
void apply_overrides(SceneDocument& document, const std::vector<Override>& overrides,
                     const std::filesystem::path& folder);

/// Refuses two keys of one group and missing required keys.
void check_groups(const SceneDocument& document);

/// "a, b and c", for messages.
std::string list_text(const std::vector<std::string>& words);

}  // namespace umax
