// The model that a step solves while pins drive some of its nodes.
#pragma once

#include <vector>

#include "core/step/workspace.h"

namespace umax {

/// The model itself where no node is driven at the time [s]; else a copy, kept in the workspace, in which these nodes are
/// fixed (core/problem/iterate.h puts them where they go) and hexes without a free node have no limit: a pin beats it.
/// What the workspace keeps of the model is made anew when other nodes are driven than before.
const Model& pinned_model(const Model& model, double time, Workspace::Data& workspace);

/// Exact points that are farther than rounding from where their pins have them.
struct MissedPins {
  std::vector<int> hexes;  // that hold them, ascending
  double farthest = 0;     // [cells]
};

/// Those of the points that springs hold at the positions. options: of the step that ended there, at the time [s].
MissedPins missed_pins(const Model& model, const StepOptions& options, const Points& positions, double time);

/// Puts the limits of these hexes aside in the model that pinned_model() made of this one; all others have theirs.
void put_limits_aside(const Model& model, const std::vector<int>& hexes, Workspace::Data& workspace);

/// The hexes and those that share a node with one of them, ascending.
std::vector<int> with_neighbours(const Model& model, const std::vector<int>& hexes);

}  // namespace umax
