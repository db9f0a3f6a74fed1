// Bodies to test with: blocks, the paper's beam and sphere, with surface points that ride in their lattice.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/element/rotation.h"
#include "core/step/step.h"

namespace umax::test {

/// Weights of points [m] that lie in the full grid of a box lattice.
EmbeddedPoints embed_in_box(const Lattice& lattice, const Vector3i& num_cells, const Points& points);

Points as_points(const std::vector<Vector3d>& list);

/// The faces of a box, `per_edge` points along each cell's edge (1: the lattice's own nodes).
Points box_surface(const Vector3i& num_cells, const Vector3d& origin, const Vector3d& cell_size, int per_edge);

/// Evenly spread over a sphere (golden spiral).
Points sphere_surface(const Vector3d& centre, double radius, int count);

/// Samples a signed distance on a grid over [low, high], with a margin of two spacings.
std::shared_ptr<SampledDistance> sample_distance(const std::function<double(const Vector3d&)>& distance,
                                                 const Vector3d& low, const Vector3d& high, double spacing);

double box_distance(const Vector3d& p, const Vector3d& low, const Vector3d& high);

/// A block of num_cells cubes with its lowest corner at origin, full mass, its faces as surface.
Body make_block(const Vector3i& num_cells, const Vector3d& origin, double cell_size, int points_per_edge = 2);

/// The same body turned about the world's origin. Its lattice becomes irregular.
Body turned(Body body, const Matrix3d& rotation);

/// The paper's beam: 14 x 2 x 2 hexes, 1 x 0.12 x 0.12 m, clamped at x = 0.
Body make_beam();
/// Centre of the beam's free end.
int beam_tip();

/// The paper's sphere of radius 1 m in a cube of cells^3 hexes, all of them kept.
Body make_sphere(int cells, const Vector3d& centre, int num_points = 400);

Obstacle make_ground(double friction = 0);

void limit_energy(Body& body, double energy);

/// What make_model() says against a body, as bad data; nothing if it takes it.
std::string complaint(const Body& body);

/// Steps and hands every report and state to `look`.
template <class Look>
void simulate(const Model& model, const StepOptions& options, int steps, State& state, const Look& look) {
  Workspace workspace(model);
  for (int i = 0; i < steps; ++i) look(step(model, options, workspace, state), std::as_const(state));
}

State simulate(const Model& model, const StepOptions& options, int steps);

double total_mass(const Model& model);
Vector3d mean_of(const VectorXd& mass, const Points& values);
Vector3d momentum(const Model& model, const State& state);
Vector3d angular_momentum(const Model& model, const State& state);

}  // namespace umax::test
