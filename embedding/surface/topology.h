// Which vertices coincide and which triangles share an edge: what reports, normals and winding numbers are built on.
#pragma once

#include <utility>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// #V: for every vertex the lowest index among the vertices at exactly its position (-0 equals 0).
std::vector<int> weld(const Points& positions);

/// One side of a triangle on welded vertices; forward: the triangle runs from low to high.
struct EdgeUse {
  int low = 0, high = 0;
  int triangle = 0;
  bool forward = true;
};

/// The three sides of every triangle whose welded corners differ, sorted by (low, high, triangle, direction).
std::vector<EdgeUse> edge_uses(const Triangles& triangles, const std::vector<int>& welded);

/// Calls visit(first, last) for every run of uses of one edge.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first;
    while (last < uses.size() && uses[last].low == uses[first].low && uses[last].high == uses[first].high) ++last;
    visit(uses.begin() + std::ptrdiff_t(first), uses.begin() + std::ptrdiff_t(last));
    first = last;
  }
}

/// Sets of integers 0 .. n-1 that are merged; the root of a set is its lowest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n);
  int root(int i);
  void merge(int a, int b);

 private:
  std::vector<int> parent_;
};

/// #T: connected component (through shared welded vertices) of every triangle, numbered by first appearance; and how
/// many.
std::pair<std::vector<int>, int> triangle_components(const Triangles& triangles, const std::vector<int>& welded);

/// Triangles whose corners are welded and whose direction agrees with their neighbours' across every edge that has just
/// two triangles; of each such patch the smaller part (by area) is turned. Reports how many were turned.
Triangles oriented_consistently(const TriangleMesh& mesh, const std::vector<int>& welded, int* num_turned = nullptr);

/// Volume [m^3] enclosed by consistently directed triangles (divergence theorem about the centre of the bounding box).
double signed_volume(const Points& positions, const Triangles& triangles);

/// [m^2] of all triangles.
double surface_area(const TriangleMesh& mesh);

}  // namespace umax
