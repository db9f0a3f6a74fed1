// What a curve of measurements looks like, without a law: where it bends, what is left of its slope, how its misfit
// lies.
#pragma once

#include <vector>

#include "tools/fit/measurements.h"

namespace umax {

/// A stiffness [Pa] (stress over stretch) and the stretch at which it ends, from the best cut of the points by force.
struct Knee {
  double stiffness = 0;
  double stretch = 0;  // 0: none
};

Knee find_knee(const Measurements& measurements);

/// How much of the elastic compliance 1/young [Pa] is left among the limited points (one flag for each point), less
/// twice its standard error [-]: the slope of their stretch over stress. 0 for points of one force.
double compliance_left(const Measurements& measurements, const std::vector<char>& limited, double young);

/// Correlation [-] of each point's residual, measured stretch less the given one, with its neighbour's by force. Noise
/// has about 0; 1 is another law.
double residual_correlation(const Measurements& measurements, const std::vector<double>& stretch);

}  // namespace umax
