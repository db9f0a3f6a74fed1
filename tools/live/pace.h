// The clock of a live session: real time, or slower where asked for or where steps take longer. Step sizes never change.
#pragma once

#include <algorithm>
#include <cmath>

namespace umax {

struct Pace {
  double time_step = 1.0 / 60;  // [s] simulated
  double slower = 1;            // [-] than real time, as asked for
  double cost = 0;              // [s] that a step takes, smoothed
  double period = 0;            // [s] from one step to the next; 0: none yet

  /// [-] of real time.
  double rate() const { return period > 0 ? time_step / period : 1 / slower; }
  /// It is behind what was asked for, since steps take so long.
  bool is_behind() const { return period > 1.05 * time_step * slower; }
};

/// To be called after each step with what it took [s]: the time to the next step follows smoothly.
inline void add_step(Pace& pace, double took) {
  constexpr double spare = 1.03;   // [-] all that is done between two steps is in `took`
  constexpr double memory = 0.25;  // [s] in which the clock follows
  const double wanted_before = pace.time_step * pace.slower;
  if (pace.period <= 0) pace.period = wanted_before;
  pace.cost += (pace.cost > 0 ? 0.2 : 1.0) * (took - pace.cost);
  const double wanted = std::max(wanted_before, spare * pace.cost);
  pace.period += (wanted - pace.period) * (1 - std::exp(-std::max(pace.period, took) / memory));
}

}  // namespace umax
