// What lies inside a surface by its winding number: right for self-intersecting, nested and overlapping parts, and for
// open surfaces, whose holes are capped first.
//
// The directed triangles are a chain S with boundary dS (a sum of closed loops). Coning every connected part of dS from
// its centroid gives a cap C with
//   dC = -dS
// so that S + C is closed and has a whole winding number everywhere. Inside: not 0.
#pragma once

#include <functional>

#include "core/base/triangle_mesh.h"

namespace umax {

struct ClosedSurface {
  Points positions;     // [m] the mesh's vertices, then the caps' apexes
  Triangles triangles;  // welded corners, directed consistently, caps last
  int num_holes = 0;    // connected parts of the boundary that were capped
  int num_boundary_edges = 0;
  int num_turned = 0;  // triangles whose direction disagreed with their neighbours'
  double volume = 0;   // [m^3] signed; overlaps count twice
};
ClosedSurface close_surface(const TriangleMesh& mesh);

/// Lines along z at x = origin.x + i spacing.x, y = origin.y + j spacing.y.
struct LineGrid {
  Eigen::Vector2d origin{0, 0}, spacing{1, 1};  // [m]
  Eigen::Vector2i size{0, 0};
  int group = 1;  // lines i that share i / group are visited by one thread, in order
};

/// Calls visit(i, j, z0, z1) for every stretch of a line that lies inside, in order of (i, j, z) within a group; groups
/// in parallel.
void visit_inside(const ClosedSurface& surface, const LineGrid& lines,
                  const std::function<void(int, int, double, double)>& visit);

/// About how often the lines of an endless grid cross triangles.
double num_crossings(const ClosedSurface& surface, const LineGrid& lines);

/// More crossings than this take long: thousands of triangles above each other. Fewer lines tell as much then.
constexpr double most_crossings = 3e7;

/// [m^3] inside, overlaps counted once; from about num_lines^2 lines, fewer where that would be most_crossings.
double inside_volume(const ClosedSurface& surface, int num_lines = 512);

}  // namespace umax
