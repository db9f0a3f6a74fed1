// What a specimen reads at any load and limit, from few simulated ones: fits ask for thousands.
//
// Below the load at which the fullest hex reaches the limit, the limit does nothing: one curve of the specimen without
// limits, simulated at evenly spaced loads and interpolated by cubics, serves all limits. Beyond, specimens with limits
// are simulated, and what they read relative to where their limit set in is interpolated.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <vector>

#include "tools/fit/specimen.h"

namespace umax {

class Response {
 public:
  Response(Loading loading, double poisson);

  /// The specimen's reading at a load >= 0 [-] (nominal stress over Young's modulus). Nothing where no specimen bears
  /// the load without a limit.
  std::optional<SpecimenReading> at(double load, double limit_stretch);

  /// The load [-] at which the fullest hex reaches the limit; nothing where no load does.
  std::optional<double> onset(double limit_stretch);

 private:
  static constexpr std::array excess_loads{1.0, 1.02, 1.05, 1.1, 1.15, 1.2,
                                           1.3, 1.5,  2.0,  4.0, 10.0};  // [-] load over the limit's onset
  /// Stretch beyond the limit's onset over that at the onset, at each of excess_loads. Empty: could not be simulated.
  using Locking = std::vector<double>;

  std::optional<double> find_onset(double limit_stretch);
  bool cover(double load);
  bool cover_peak(double peak_stretch);
  bool add_knot();
  SpecimenReading unlimited(double load) const;
  const Locking& locking(int grid_limit);
  std::optional<double> locking_at(double excess, double limit_stretch);

  Loading loading_;
  double poisson_;
  Specimen specimen_;
  std::vector<SpecimenReading> knots_{SpecimenReading{}};  // at load 0, spacing, 2 spacing, ...
  bool complete_ = false;                                  // no further knot can be simulated
  std::map<int, Locking> locking_;                         // by limit, on a logarithmic grid
  std::optional<double> last_limit_, last_onset_;          // of the last question, which is mostly the next one too
};

}  // namespace umax
