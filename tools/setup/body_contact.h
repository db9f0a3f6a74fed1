// Contact between bodies, from a scene to the model: its exceptions, and what a user is told before a run.
#pragma once

#include <string>
#include <vector>

#include "core/model/model.h"
#include "core/problem/step_options.h"
#include "scenes/scene.h"

namespace umax {

/// The scene's pairs, whose names are those of its bodies, by the bodies' places in it.
std::vector<BodyPair> make_pairs(const Scene& scene);

/// #bodies: may any surface, its own perhaps, touch this body's?
std::vector<char> touched_bodies(const Scene& scene);

/// Names the bodies whose mesh is open, so far as they are to touch other bodies or themselves: one line for each of
/// what they cannot do, whatever their number.
void warn_of_open_meshes(const Model& model, std::vector<std::string>& warnings);

/// Says so where the scene's method, the paper's, lets several bodies pass through each other.
void warn_of_paper_method(const Model& model, SolverMethod method, std::vector<std::string>& warnings);

/// Names the bodies that start inside each other, and how deep.
void warn_of_overlaps(const Model& model, std::vector<std::string>& warnings);

/// Throws Error (bad_data) that names two bodies of which one starts deeper inside the other than a cell of the finer one,
/// or with more than 5 % of its vertices.
void require_clear_start(const Model& model);

}  // namespace umax
