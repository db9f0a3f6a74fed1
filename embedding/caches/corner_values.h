// Texture coordinates of triangle corners as formats want them: each pair once with an index, or one of each vertex.
#pragma once

#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// The distinct values of corners, in the order in which they are first met.
struct CornerValues {
  std::vector<Eigen::RowVector2f> values;
  std::vector<int> index;  // 3 #T into values; empty like them where corners have none
};
CornerValues distinct_values(const TextureCoordinates& corners);

/// Vertices of which each has one texture coordinate: the first #V are the surface's own, in their order; behind them
/// follows a copy of a vertex for each further value that its corners have.
struct SplitVertices {
  std::vector<int> source;                      // of every vertex, own or copy: the surface's vertex
  Triangles triangles;                          // #T x 3 into source
  std::vector<Eigen::RowVector2f> coordinates;  // of every vertex; empty where corners have none
};
SplitVertices split_vertices(Eigen::Index num_vertices, const Triangles& triangles, const TextureCoordinates& corners);

}  // namespace umax
