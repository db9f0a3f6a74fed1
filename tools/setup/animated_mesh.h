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

/// A mesh's vertices among those of its file, some of which no triangle may have, and its triangles.
struct FileVertices {
  Eigen::Index count = 0;            // #V of the mesh
  std::vector<int> places = {};      // #V in the file's order; empty: all as there
  Eigen::Index num_in_file = count;  // with those that no triangle has
  Triangles triangles = {};          // of the mesh; empty: not compared
};

/// Reads an animation of a mesh, whose units and axes are those of the mesh: of all of its file's vertices, or of those of
/// triangles alone. Throws Error: not_found; bad_data where it is damaged, of other vertices, has gaps in its times, or
/// where meshes of a folder have not half of their edges in common with the mesh: as many vertices, but others. notes: for
/// the user, that fewer edges than all are the same among them.
MeshMotion read_motion(const CacheSource& cache, const FileVertices& vertices, const Eigen::Affine3d& placed_from_own,
                       const ClipDescription& clip, std::vector<std::string>& notes);

/// Gives the obstacle the animated mesh's surface. mesh: at rest, in the obstacle's own frame [m]; thickness: [m], unset:
/// as it needs. Throws Error (bad_data) for a mesh without area.
void animate(const TriangleMesh& mesh, MeshMotion motion, std::optional<double> thickness, Obstacle& obstacle,
             std::vector<std::string>& notes);

}  // namespace umax
