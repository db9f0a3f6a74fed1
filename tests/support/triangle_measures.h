// Measures of single triangles that tests judge surfaces by: solid angle, distance of a point, crossing with a segment.
//
// [OS83]   tan(w / 2) = a . (b x c) / (|a||b||c| + (a . b)|c| + (b . c)|a| + (c . a)|b|)
//
// w: solid angle of the triangle [sr], positive where it is seen from behind;  a, b, c: its corners from the point
// [OS83]: A. van Oosterom, J. Strackee. The Solid Angle of a Plane Triangle. IEEE Trans. Biomed. Eng. 30(2), 1983.
#pragma once

#include <optional>

#include "core/base/types.h"

namespace umax::test {

struct Triangle {
  Vector3d a, b, c;  // counter-clockwise as seen from outside
};

/// Solid angle [sr] of the triangle seen from x, 0 from its own corners. At other points of itself it jumps.
double solid_angle(const Triangle& triangle, const Vector3d& x);

/// Squared distance [m^2] from x to the nearest point of the triangle, which may be a segment or a point.
double squared_distance(const Triangle& triangle, const Vector3d& x);

/// Where the segment passes through the triangle, as a fraction of the way from p to q; nothing where it only touches.
/// A segment that passes through the edge of two triangles crosses at least one of them, whatever rounding says.
std::optional<double> crossing(const Vector3d& p, const Vector3d& q, const Triangle& triangle);

}  // namespace umax::test
