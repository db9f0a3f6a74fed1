// The variants of a scene: every combination of the values that --vary lists.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

/// "--vary KEY=A,B,C"; several keys take each value together.
struct Variation {
  std::vector<std::string> keys;
  std::vector<std::string> values;  // as the user wrote them
};

/// Splits at commas outside of brackets, braces and quotes. Throws Error (usage): no key, no value, an empty or
/// repeated value, a bracket or quote that does not close.
Variation parse_variation(const std::string& text);

struct SceneVariant {
  std::string name;                 // of its folder, unique: "stretch=5%,young=100kPa"
  std::string label;                // "stretch 5%, young 100 kPa"
  std::vector<Override> settings;   // that make it
  std::vector<std::string> values;  // one of each variation
};

inline constexpr int most_variants = 100;

/// The last variation runs fastest. Throws Error (usage): no variation, a key that is varied twice, more than
/// most_variants.
std::vector<SceneVariant> combinations(const std::vector<Variation>& variations);

}  // namespace umax
