// The model that a step solves while pins drive some of its nodes.
#pragma once

#include "core/step/workspace.h"

namespace umax {

/// The model itself where no node is driven at the time [s]; else a copy, kept in the workspace, in which these nodes are
/// fixed (core/problem/iterate.h puts them where they go) and hexes without a free node have no limit: a pin beats it.
/// What the workspace keeps of the model is made anew when other nodes are driven than before.
const Model& pinned_model(const Model& model, double time, Workspace::Data& workspace);

}  // namespace umax
