// What share of a hex weighs when a body has the mass of its mesh (material.mass = "mesh").
#pragma once

#include "core/model/lattice.h"

namespace umax {

/// [-] A hex never weighs less than this share of its volume, so that no node is weightless.
inline constexpr double least_filled_fraction = 0.05;

/// The share [-] of each hex that the surface fills, at least 5 %: #E.
inline VectorXd weighing_fractions(const Lattice& lattice) {
  return lattice.filled_fraction.cwiseMax(least_filled_fraction);
}

}  // namespace umax
