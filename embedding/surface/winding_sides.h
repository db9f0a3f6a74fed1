// Winding numbers of a closed surface on both sides of its own triangles.
#pragma once

#include <array>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// Winding numbers just behind and just in front of a triangle.
struct WindingSides {
  int behind = 0, front = 0;
};

class SideFinder {
 public:
  /// The surface has to outlive the finder. Its directed triangles are a closed chain, with one vertex per place.
  SideFinder(const Points& positions, const Triangles& triangles);

  /// At a point inside a triangle that has an area. Other triangles nearer than 1e-7 of the largest extent count as
  /// lying in the same place: there is nothing between them.
  WindingSides sides_at(int triangle, const Vector3d& point) const;

 private:
  // the triangles over each cell of a grid across one axis
  struct Columns {
    int u = 0, v = 1, axis = 2;
    Eigen::Vector2d origin{0, 0}, spacing{1, 1};  // [m]
    int size = 1;                                 // cells along u and along v
    std::vector<int> starts, triangles;           // of cell c: triangles[starts[c]] ... triangles[starts[c + 1] - 1]

    int cell_along(int side, double coordinate) const;
  };
  Columns make_columns(int axis) const;
  template <class Visit>
  void for_each_cell(const Columns& columns, int triangle, const Visit& visit) const;
  long long count_entries(const Columns& columns) const;

  const Points& positions_;
  const Triangles& triangles_;
  Vector3d low_{0, 0, 0}, extent_{0, 0, 0};  // [m]
  std::array<Columns, 3> columns_;
};

}  // namespace umax
