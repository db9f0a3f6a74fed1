// A mesh as an obstacle, or as the rest shape of a body: signed distances on a dense grid, and points on its sharp
// edges.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/obstacle.h"

namespace umax {

struct DistanceGridOptions {
  int max_samples_per_axis =
      128;          // [-] along the longest edge of the bounding box; raising it sharpens edges, memory grows cubed
  double band = 0;  // [m] distances are right to 1 % of a sample this far out (at least 3 samples); further out
                    // they follow from their neighbours, to a few per cent
};

/// Distances [m] to the surface, negative inside, on a grid that reaches three samples beyond the bounding box. Inside
/// is told as voxelize() does it, so open meshes are capped: `notes`, when given, receives what was done.
SampledDistance make_distance_grid(const TriangleMesh& mesh, const DistanceGridOptions& options = {},
                                   std::vector<std::string>* notes = nullptr);

struct SharpEdgeOptions {
  double spacing = 0.02;         // [m] largest distance between points along an edge
  double dihedral_degrees = 30;  // [deg] an edge is sharp when its triangles' normals differ by more
};

/// The ends of the sharp convex edges and of open borders, as the lowest vertices at their places.
std::vector<std::array<int, 2>> sharp_edges(const TriangleMesh& mesh,
                                            double dihedral_degrees = SharpEdgeOptions().dihedral_degrees);

/// Points along the sharp convex edges, corners included, and along open borders; #P x 3 [m], no two at the same place.
Points sharp_edge_points(const TriangleMesh& mesh, const SharpEdgeOptions& options = {});

}  // namespace umax
