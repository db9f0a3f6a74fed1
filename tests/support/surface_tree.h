// A hierarchy over a surface's triangles that tests search: winding numbers, nearest distances, what meets a box.
//
// [JKS13]  w(x) = sum_t w_t(x) / (4 pi)                      generalised winding number of the surface about x [-]
// [BDSL18] sum_t w_t(x) ~ A . (c - x) / |c - x|^3            of triangles further than `far_field` times their extent
//
// w_t: solid angle of triangle t [sr] (triangle_measures.h);  A, c: the triangles' area vector [m^2] and centre [m]
// [JKS13]:  A. Jacobson, L. Kavan, O. Sorkine. Robust Inside-Outside Segmentation using Generalized Winding Numbers.
//           SIGGRAPH 2013.
// [BDSL18]: G. Barill, N. Dickson, R. Schmidt, D. Levin, A. Jacobson. Fast Winding Numbers for Soups and Clouds.
//           SIGGRAPH 2018.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "tests/support/triangle_measures.h"

namespace umax::test {

using Box = Eigen::AlignedBox3d;

/// Which triangles lie together. One tree serves all shapes of a surface.
struct SurfaceTree {
  struct Node {
    int begin = 0, end = 0;  // its triangles
    int right = -1;          // its second child; the first one follows it; -1: a leaf
    bool is_leaf() const { return right < 0; }
  };
  std::vector<Node> nodes;  // a node stands before its children
  Triangles triangles;      // #T x 3, leaf after leaf
};

/// Where a tree's triangles are.
struct TreeShape {
  struct Node {
    Box box;
    Vector3d area = Vector3d::Zero();    // [m^2] sum of the triangles' area vectors
    Vector3d centre = Vector3d::Zero();  // [m] mean of the triangles' centres by area
    double total_area = 0;               // [m^2]
    double radius = 0;                   // [m] of a ball about the centre that holds the box
  };
  Points positions;  // #V x 3 [m]
  std::vector<Node> nodes;
};

/// Triangles that a search passes over.
struct LeftOut {
  std::vector<char> triangles;  // #T
  std::vector<int> nodes;       // how many of a node's triangles
};

/// What is searched; refers to its parts.
struct SurfaceView {
  const SurfaceTree& tree;
  const TreeShape& shape;
  const LeftOut* left_out = nullptr;
};

SurfaceTree build_tree(const Triangles& triangles, const Points& positions);
TreeShape shape_tree(const SurfaceTree& tree, Points positions);
LeftOut leave_out(const SurfaceTree& tree, const std::vector<int>& triangles);

Triangle triangle_at(const SurfaceView& surface, int triangle);

/// 1 inside a closed surface, 0 outside, in between near what an open one lacks. Within 0.03 of the exact sum.
double winding_number(const SurfaceView& surface, const Vector3d& x);

/// Distance [m] from x to the nearest triangle, infinite without one.
double distance(const SurfaceView& surface, const Vector3d& x);

/// Triangles whose boxes meet the box, in the tree's order; whether there are any.
std::vector<int> triangles_in(const SurfaceView& surface, const Box& box);
bool has_triangles_in(const SurfaceView& surface, const Box& box);

}  // namespace umax::test
