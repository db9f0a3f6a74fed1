// How deep bodies lie inside each other and themselves, measured afresh on deformed triangles by winding numbers.
// Shares nothing with contact, which it judges: no maps back to rest, no sampled distances, no remembered sides.
//
// Between bodies   x lies inside a body where w(x) > 1/2; its depth is the distance to the body's nearest triangle.
// Within a body    x, which rides in hex h, lies inside a far part where w_h(x) - W_h(X) > 1/2; its depth is the
//                  distance to the nearest far triangle.
//
// w:   winding number of a body's deformed surface [-] (surface_tree.h)
// w_h: of its far triangles alone: those without a vertex in a hex that shares a node with h
// W_h: of these at rest, about X, the same point at rest: what overlaps there does not count
//
// Far triangles are an open surface. Where x passes through it, its winding number jumps by 1; else it changes with the
// bending of the surface around x, by 1/2 if a flat face folds onto itself.
//
// Points are all vertices, and points on triangles with edges longer than a quarter cell at rest. Edges are cut at
// every triangle of the other surface (or the far part); the middle of each section that lies inside is measured, and
// the edge's ends.
//
// Limits: a surface without an inside holds nothing. Depth is told too small where the nearest triangle is one that is
// buried in the body. Where hexes are inverted, their surface is inside out and holds nothing. Overlaps between hexes
// that share a node are not seen.
#pragma once

#include <vector>

#include "tests/support/measured_body.h"

namespace umax::test {

/// The deepest one of its kind: by cells; of equal ones the first by body, then by triangle.
struct Penetration {
  double cells = 0;                   // depth by the smaller of the two bodies' cells
  double depth = 0;                   // [m]
  int body = -1, other = -1;          // in the model: whose point, and in what; equal within a body
  Vector3d place = Vector3d::Zero();  // [m] world
};

struct PenetrationReport {
  Penetration between, within;  // of points
  Penetration crossing;         // of edges
  long points_inside = 0;       // of all bodies, each once per body that it lies in
  long edges_crossing = 0;      // that cross a surface and lie inside it with a part, likewise
};

/// Takes a further report into account: the deepest of both, counts added.
void add(const PenetrationReport& report, PenetrationReport& sum);

/// The model's bodies at the node positions of a state. Only pairs that may touch are measured. The same for any number
/// of threads.
PenetrationReport measure_penetration(const Model& model, const std::vector<MeasuredBody>& bodies,
                                      const Points& node_positions);

}  // namespace umax::test
