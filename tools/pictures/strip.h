// One picture of several instants or several runs: their bodies stand side by side on one ground.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// What stands in one place of the strip.
struct StripItem {
  std::shared_ptr<const Simulation> simulation;
  State state;
  std::string label;  // below it; may be empty
};

/// From left to right, as wide as each is, seen in the direction of the first scene's camera; its ground, lights, sky
/// and heat map are all items'. The lights are repeated for every item, dimmed by what neighbours' add; no cage is
/// drawn. All items have the same render.heatmap. Throws Error as make_stage() does.
RenderScene make_strip(const std::vector<StripItem>& items, double aspect);

}  // namespace umax
