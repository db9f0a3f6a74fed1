// What experiments read off their runs.
#pragma once

#include <functional>
#include <vector>

#include "tools/reproduce/workbench.h"

namespace umax {

/// The frame at which a measure of the state is smallest; the first of equals. Frames first .. last are looked at.
int frame_of_least(const Run& run, int first, int last, const std::function<double(const State&)>& measure);

/// [m] centre of mass.
Vector3d centre_of_mass(const Model& model, const State& state);

/// #V x 3 [m] vertices of the only body's surface.
Points surface_points(const Run& run, const State& state);

/// [m] highest point of the surface.
double highest_point(const Run& run, const State& state);

/// The largest value of a column of steps.csv; 0 without steps.
double largest(const std::vector<double>& values);

/// Steps of a run that did not converge.
int num_unconverged(const Run& run);

/// U/U_max over the hexes of a state.
struct RatioSpread {
  double least = 0, median = 0, largest = 0;
  double share_at_limit = 0;  // [-] of all hexes, U/U_max >= 0.99
};
RatioSpread ratio_spread(const VectorXd& ratios);

}  // namespace umax
