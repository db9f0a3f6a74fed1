// The range in which a key of a scene may be varied: "--vary body.figure.limit.stretch=2%..60%".
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

/// From low to high, at places from 0 to 1 of it: evenly, or where both ends are positive and one is ten times the other
/// or more, by equal factors.
struct KeyRange {
  std::string key;
  std::string short_key;     // enough of it to tell it from the others
  double low = 0, high = 1;  // in the unit of the key's bare numbers
  bool logarithmic = false;
  std::string unit;           // that the user writes it in: "%"; may be empty
  double unit_size = 1;       // in the key's
  std::optional<double> own;  // where the scene's own value is, if it is in the range

  double value_at(double place) const;
  double place_of(double value) const;
};

/// Reads "KEY=A..B" by what the scene makes of A and B; one without a unit has the other's. Throws Error (usage,
/// bad_data) that names --vary.
KeyRange parse_range(const std::string& text, const std::string& scene, const std::vector<Override>& settings);

/// The value at a place as the scene will have it: five digits, in the user's unit.
std::string value_text(const KeyRange& range, double place);

}  // namespace umax
