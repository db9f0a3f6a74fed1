// How far a limb has collapsed: a limb is the surface's vertices in a box, and has a height and a length.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace umax {

/// Where a limb is at rest, as fractions of the surface's bounding box: 0 at its lowest corner, 1 at its highest.
struct LimbBox {
  Vector3d low{0, 0, 0}, high{1, 1, 1};
};

/// The own right leg, knee included, of the built-in figure and of the Stanford armadillo: both face +z with y up.
inline const LimbBox figure_right_leg{{0.20, 0, 0.55}, {0.43, 0.24, 1}};
inline const LimbBox armadillo_right_leg{{0.15, 0, 0.10}, {0.44, 0.37, 1}};

struct Limb {
  std::vector<int> vertices;     // of the surface, ascending
  std::vector<int> top, bottom;  // those in the highest and the lowest 15 % of the limb's height at rest
  double rest_height = 0;        // [m]
  double rest_length = 0;        // [m]
};

/// The limb of a surface (#V x 3 [m], placed at rest, y up) in a box. Throws Error (bad_data) when it holds no vertex.
Limb select_limb(const Points& rest, const LimbBox& box);

/// [m] vertical extent of the limb's vertices: what is left of it when it collapses into the ground.
double limb_height(const Limb& limb, const Points& positions);

/// [m] from the mean of its bottom vertices to that of its top vertices: turning the limb does not change it.
double limb_length(const Limb& limb, const Points& positions);

}  // namespace umax
