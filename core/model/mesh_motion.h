// Vertices of a mesh that another program has animated: samples over time, linear in between.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// Before its first sample and after its last one the mesh stands still.
struct MeshMotion {
  std::vector<double> times;      // [s] of the samples in the clip, strictly increasing, one at least
  std::vector<float> samples;     // one after another, #V x 3, in the units and axes of their file
  Eigen::Index num_vertices = 0;  // #V
  Eigen::Affine3d placed_from_own = Eigen::Affine3d::Identity();  // [m] from those units and axes
};

/// The vertices at a time [s]: #V x 3 [m].
Points positions_at(const MeshMotion& motion, double time);

/// The time [s] within the samples at which the mesh is as it is at `time`.
double time_within(const MeshMotion& motion, double time);

/// The largest speed [m/s] of a vertex between two samples.
double largest_speed(const MeshMotion& motion);

}  // namespace umax
