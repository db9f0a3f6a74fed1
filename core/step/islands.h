// Bodies that may touch in a step are solved together, others apart: each such island has its own iterations, step lengths,
// halvings and linear solver.
#pragma once

#include <memory>
#include <vector>

#include "core/step/workspace.h"

namespace umax {

/// Some bodies of a model by themselves.
struct Island {
  std::vector<int> bodies;  // ascending, of the whole model
  Model model;
  Workspace::Data workspace;
};

/// Groups of bodies (ascending, by their first one) that have touched in the last step, or of which hexes come near each
/// other on their way or where the bodies go if nothing holds them.
std::vector<std::vector<int>> find_islands(const Model& model, const ContactGeometry& geometry, double time_step,
                                           const State& state);

/// Groups joined where vertices of one are inside another after a step; the same groups where none is.
std::vector<std::vector<int>> join_islands(const Model& model, const ContactGeometry& geometry, const State& start,
                                           const State& end, const std::vector<std::vector<int>>& islands);

/// How deep vertices of one island are inside another at most [m].
double deepest_across(const Model& model, const ContactGeometry& geometry, const Points& positions,
                      const std::vector<std::unique_ptr<Island>>& islands);

std::unique_ptr<Island> make_island(const Model& model, const ContactGeometry& geometry,
                                    const std::vector<int>& bodies);

/// What belongs to the island's nodes of points of all nodes; of none: none.
Points part_of(const Model& model, const Points& points, const Island& island);

/// The part of a state that belongs to the island, and its way back.
State part_of(const Model& model, const State& state, const Island& island);
void put_back(const Model& model, const Island& island, const State& part, State& state);

}  // namespace umax
