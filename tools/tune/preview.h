// What a first look leaves out: smaller pictures by the rasteriser, coarser cages.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_document.h"

namespace umax {

struct Preview {
  std::vector<Override> settings;
  std::vector<std::string> notes;  // what they change, for the user
};

/// The settings that make this scene quick to look at. Sections and keys in `chosen` (those that the user varies or
/// sets) are left alone; so are cages whose limit is an energy per hex, which would mean something else on another
/// cage.
Preview preview_of(const Scene& scene, const std::vector<std::string>& chosen);

}  // namespace umax
