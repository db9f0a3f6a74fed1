// From the values of a plot's axis to pixels and ticks.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tools/pictures/plot.h"

namespace umax {

struct Tick {
  double value;
  std::string label;  // empty: a line of the grid only
};

/// How an axis maps values to pixels, and where its ticks are.
struct Scale {
  bool logarithmic = false;
  double low = 0, high = 1;   // values at the ends
  double begin = 0, end = 1;  // [px] where these are
  int exponent = 0;           // tick labels are in units of ten to this
  std::vector<Tick> ticks{};

  double at(double value) const {
    const double share = logarithmic ? (std::log10(value) - std::log10(low)) / (std::log10(high) - std::log10(low))
                                     : (value - low) / (high - low);
    // Cairo's coordinates have a range of some million pixels
    return std::clamp(begin + share * (end - begin), -1e5, 1e5);
  }
};

/// Whether a value has a place on an axis.
bool is_shown(double value, bool logarithmic);

/// The scale of an axis for values between `low` and `high` (nothing to show: low > high) with about `num_ticks` ticks,
/// from pixel `begin` to `end`. Where `rounded`, ends that the axis does not give go to the next tick.
Scale make_scale(const PlotAxis& axis, double low, double high, double begin, double end, int num_ticks, bool rounded);

/// "⁻³" for -3.
std::string superscript(int number);

}  // namespace umax
