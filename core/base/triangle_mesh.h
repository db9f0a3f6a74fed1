// A triangle mesh: positions, triangles and what may come with them. Read from files, deformed by a cage, drawn.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace umax {

using TextureCoordinates = Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>;  // (u right, v up) in [0, 1]

struct TriangleMesh {
  Points positions;                        // #V x 3 [m], in the order and number of the file
  Triangles triangles;                     // #T x 3 indices into positions, counter-clockwise from outside
  Points normals;                          // #V x 3 unit, or empty
  TextureCoordinates texture_coordinates;  // 3 #T x 2, one per triangle corner, or empty
  Points colors;                           // #V x 3 linear Rec. 709 RGB, or empty
  std::vector<int> materials = {};         // #T which of the file's materials each has, or empty: all one

  Eigen::Index num_vertices() const { return positions.rows(); }
  Eigen::Index num_triangles() const { return triangles.rows(); }
};

}  // namespace umax
