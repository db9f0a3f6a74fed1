// What readers of text and binary meshes gather: vertices and polygons, which become one mesh of triangles.
#pragma once

#include <array>
#include <vector>

#include "embedding/mesh_record/mesh_file.h"

namespace umax {

struct MeshAssembly {
  MeshFile file;                              // its positions stand before polygons are added
  std::vector<std::array<int, 3>> triangles;  // vertices
  std::vector<Eigen::Vector2f> coordinates;   // three a triangle, or none
  std::vector<std::array<int, 3>> cut;        // of the polygon that was added last: places in it

  /// Adds a polygon of any number of corners; those of less than three are nothing. `name`: of the polygon, for the
  /// error (bad_data) when it names a vertex that does not exist.
  void add_polygon(const std::filesystem::path& path, long long number, const std::vector<int>& corners);

  /// The mesh of what was added. Throws Error (bad_data) where it is too large to be counted.
  MeshFile finish(const std::filesystem::path& path);
};

/// Linear colours of stored ones that are sRGB: as they are up to 1, or of 255 where some is larger.
Points linear_colors(const Points& stored);

}  // namespace umax
