// Winding numbers of a closed surface on both sides of its own triangles.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// Winding numbers just behind and just in front of a triangle.
struct WindingSides {
  int behind = 0, front = 0;
};

/// A point inside a triangle that has an area.
struct SideQuery {
  int triangle = 0;
  Vector3d point{0, 0, 0};  // [m]
};

class SideFinder {
 public:
  /// The surface has to outlive the finder. Its directed triangles are a closed chain, with one vertex per place.
  SideFinder(const Points& positions, const Triangles& triangles);

  /// Of each query. Other triangles nearer than 1e-7 of the largest extent count as lying in the same place: there is
  /// nothing between them. Many queries at once take n log n however long and thin the triangles are.
  std::vector<WindingSides> sides_at(const std::vector<SideQuery>& queries) const;

 private:
  struct Search;
  void descend(const Search& search, std::vector<int>::iterator first, std::vector<int>::iterator last,
               const std::vector<int>& triangles) const;
  WindingSides sides_at(const Search& search, const SideQuery& query, const std::vector<int>& triangles) const;
  Eigen::AlignedBox2d with_spare(const Eigen::AlignedBox2d& box) const;
  void find_copies();

  const Points& positions_;
  const Triangles& triangles_;
  double extent_ = 0;  // [m] the largest
  // Triangles with the same corners count as one, the first of them.
  std::vector<int> first_copy_;  // of each triangle
  std::vector<int> direction_;   // of each triangle: 1 or, against that of the first copy, -1
  std::vector<int> times_;       // of first copies: the sum of the copies' directions
  std::vector<int> counting_;    // first copies whose sum is not 0
};

}  // namespace umax
