// Edges and corners of obstacles against a body's surface: where a body's own vertices are too far apart to feel them.
//
// gap    =  phi(X(P)) / |F^-T grad phi|
// normal = -F^-T grad phi / |F^-T grad phi|
//
// phi: rest distance of the body's surface [m];  X(P): the material at the edge point P [m]
// F: deformation gradient at P [-];  the gap is phi to first order in the deformed body [m]
#pragma once

#include <vector>

#include "core/contact/contact.h"
#include "core/contact/contact_detection.h"

namespace umax {

/// Sample points along the shape's edges at most `spacing` [m] apart (meshes bring their own); none for round shapes.
EdgePoints edge_points(const ObstacleShape& shape, double spacing);

/// For each hex and obstacle, the deepest edge point with gap < -share * tolerance_depth, of bodies with a rest
/// distance.
std::vector<ContactCandidate> edge_candidates(const ContactStep& step, const Points& positions, double share);

/// Refreshes place, gap, normal and obstacle_motion of an edge point's contact. One that has left the cage is still
/// measured from the hex that it left.
void place_edge_contact(const ContactStep& step, const Points& positions, Contact& contact);

}  // namespace umax
