// TOML 1.0 text to scene values.
#pragma once

#include <string>
#include <string_view>

#include "scenes/scene_value.h"

namespace umax {

/// The root table of a TOML document; lines are filled into each value's place. Throws Error (bad_data) with file:line.
SceneValue parse_toml(std::string_view text, const SourcePlace& place);

/// A value as it stands after the = of a --set: TOML if it is one, a string otherwise (so that 0.1J and a/path need no
/// quotes).
SceneValue parse_override_value(const std::string& text, const SourcePlace& place);

}  // namespace umax
