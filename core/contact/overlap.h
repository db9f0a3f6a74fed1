// Bodies that are inside each other.
#pragma once

namespace umax {

/// Vertices of a body inside the surface of another, or of its own (a == b).
struct Overlap {
  int a = 0, b = 0;  // bodies
  int vertices = 0;  // of a
  double depth = 0;  // [m] of the deepest
};

}  // namespace umax
