// A body's surface as penetration is measured on it: prepared once, then measured in any number of states.
#pragma once

#include <array>
#include <vector>

#include "core/model/model.h"
#include "tests/support/surface_tree.h"

namespace umax::test {

/// A point of a triangle: the corners' mean by weights. A vertex has the weights 1, 0, 0.
struct SurfacePoint {
  Vector3i corners;
  Vector3d weights;
};

/// Points and edges that ride in the same hexes, and so have the same part of the surface far from them.
struct SamePlace {
  std::array<int, 3> hexes;  // of the model, ascending; the last one repeated where there are fewer
  std::vector<int> points, edges;
};

struct MeasuredBody {
  int body = 0;             // in the model
  EmbeddedPoints vertices;  // #V in hexes of the model
  SurfaceTree tree;         // over the triangles at rest, turned so that the volume is not negative
  TreeShape rest;           // at time 0 of the run
  // what is held against other surfaces; each belongs to the first of its triangles in the tree's order
  std::vector<SurfacePoint> points;
  std::vector<std::array<int, 2>> edges;       // vertices
  std::vector<int> point_starts, edge_starts;  // #T + 1 of the triangles
  std::vector<SamePlace> places;
  std::vector<std::vector<int>> hex_triangles;  // of the body's hexes: triangles with a vertex in it
};

struct MeasureOptions {
  double spacing = 0.25;  // [cells of the body] of points at rest, on triangles with longer edges
};

/// triangles: of the body's vertices, counter-clockwise as seen from outside, or all of them the other way round.
MeasuredBody measured_body(const Model& model, int body, const Triangles& triangles,
                           const MeasureOptions& options = {});

/// Its vertices at the node positions of a state, #V x 3 [m].
Points vertex_positions(const Model& model, const MeasuredBody& body, const Points& node_positions);

/// A point's place among the vertices' positions [m].
Vector3d point_at(const SurfacePoint& point, const Points& positions);

/// Length [m] of the longest edge.
double longest_edge(const MeasuredBody& body, const Points& positions);

}  // namespace umax::test
