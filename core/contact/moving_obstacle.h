// How an obstacle's surface moves during a step: with its pose, and by itself where it is animated.
//
// A place beside the surface moves as the nearest point of the triangles does:  X1 = X0 + (S1 - S0)
//
// S0, S1: that point of the material at the step's start and end, in the obstacle's own frame [m]
#pragma once

#include "core/contact/contact.h"

namespace umax {

/// Motion [m] during the step of the obstacle's point that is at position_t1 (world) at its end.
Vector3d obstacle_point_motion(const ContactStep& step, int obstacle, const Vector3d& position_t1);

/// Where, in the obstacle's own frame, a point that is at local_t0 when the step starts would be at its end if it moved
/// along with the triangles beside it. Itself, where the obstacle keeps its shape.
Vector3d carried_along(const ContactStep& step, int obstacle, const Vector3d& local_t0);

/// The farthest way [m] of a vertex in the obstacle's own frame between the two instants.
double largest_deformation(const ObstacleAt& from, const ObstacleAt& to);

/// How far animated obstacles move near a body on their way through a time step [cells of the body], at most. expected:
/// #N x 3 [m] where nodes go if nothing holds them.
double animated_way(const Model& model, const Points& positions, const Points& expected, double time, double time_step);

}  // namespace umax
