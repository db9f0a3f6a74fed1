// Measures how long a surface of a given size takes to follow its cage: a row of tools/bench.
#pragma once

namespace umax {

struct DeformTiming {
  long long num_vertices = 0, num_triangles = 0;
  double median_ms = 0;  // [ms] positions and normals, wall clock
  double least_ms = 0;
};

/// Deforms a bent sphere of at least num_vertices vertices in a cage of about 365 hexes `repeats` times, with the
/// threads that the caller allows.
DeformTiming time_deform(long long num_vertices = 1000000, int repeats = 21);

}  // namespace umax
