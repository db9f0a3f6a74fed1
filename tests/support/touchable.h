// Bodies with a surface that others may hit.
#pragma once

#include <string>

#include "tests/support/bodies.h"

namespace umax::test {

/// A block of cubes; its vertices are `points_per_edge` along each cell's edge.
Body touchable_block(const std::string& name, const Vector3i& num_cells, const Vector3d& origin, double cell_size,
                     int points_per_edge = 4);

/// A ball in a cube of `cells`^3 hexes, all of them kept; its mesh is an icosahedron refined three times.
Body touchable_ball(const std::string& name, int cells, const Vector3d& centre, double radius);

StepOptions without_gravity();

/// The body's nodes: rows of a model's positions or velocities.
Points nodes_of(const Model& model, const Points& of_all, int body);

double lowest_of(const Model& model, const State& state, int body);
double highest_of(const Model& model, const State& state, int body);

}  // namespace umax::test
