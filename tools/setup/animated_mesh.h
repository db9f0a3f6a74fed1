// Meshes that another program has animated: their files read, and obstacles made of them.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/mesh_motion.h"
#include "core/model/obstacle.h"
#include "scenes/scene.h"

namespace umax {

/// A mesh's vertices among those of its file, some of which no triangle may have.
struct FileVertices {
  Eigen::Index count = 0;            // #V of the mesh
  std::vector<int> places = {};      // #V in the file's order; empty: all as there
  Eigen::Index num_in_file = count;  // with those that no triangle has
};

/// Reads an animation of a mesh, whose units and axes are those of the mesh: of all of its file's vertices, or of those of
/// triangles alone. Throws Error: not_found; bad_data where it is damaged, of other vertices, or has gaps in its times.
/// notes: for the user.
MeshMotion read_motion(const CacheSource& cache, const FileVertices& vertices, const Eigen::Affine3d& placed_from_own,
                       const ClipDescription& clip, std::vector<std::string>& notes);

/// Gives the obstacle the animated mesh's surface. mesh: at rest, in the obstacle's own frame [m]; thickness: [m], unset:
/// as it needs. Throws Error (bad_data) for a mesh without area.
void animate(const TriangleMesh& mesh, MeshMotion motion, std::optional<double> thickness, Obstacle& obstacle,
             std::vector<std::string>& notes);

}  // namespace umax
