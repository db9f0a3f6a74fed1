// How contacts are found: what its two halves share, vertices against obstacles (contact_detection.cpp) and obstacles'
// edges against surfaces (edge_contact.cpp).
#pragma once

#include <cmath>

#include "core/contact/contact.h"

namespace umax {

/// [cells] of its body that a node may be away from where it was expected before hexes that may touch are looked for anew.
inline constexpr double encounter_margin = 0.15;

/// A point that may join the working set.
struct ContactCandidate {
  ContactPoint point;  // this and the next two as in Contact
  int obstacle = 0, hex = 0;
  double gap = 0;  // [m]
};

/// Points whose depths [m] differ by less are tied: the first one counts, whatever rounding says.
inline double tied_depth(const Model& model, int hex) {
  return 1e-6 * tolerance_depth(model, hex);
}

struct BoundingSphere {
  Vector3d centre;
  double radius;
};

/// Trilinear maps stay in the convex hull of the nodes, so the sphere holds every point of the hex.
inline BoundingSphere bounding_sphere(const Matrix8x3d& nodes) {
  const Vector3d centre = nodes.colwise().mean().transpose();
  return {centre, std::sqrt((nodes.rowwise() - centre.transpose()).rowwise().squaredNorm().maxCoeff())};
}

}  // namespace umax
