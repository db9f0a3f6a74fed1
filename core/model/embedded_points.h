// Points inside hexes that move with them (surface vertices, probes, contact points): which hex, and where in it.
#pragma once

#include "core/base/types.h"

namespace umax {

/// Point p is at sum_n weights(p, n) * nodes(hexes(hex[p], n)).
struct EmbeddedPoints {
  VectorXi hex;                                                       // #P
  Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor> weights;  // #P x 8, rows sum to 1

  Eigen::Index size() const { return hex.size(); }
};

}  // namespace umax
