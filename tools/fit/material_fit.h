// Young's modulus, limit and Poisson's ratio from measurements, by least squares in the stretch at given force: at the
// limit the force may be anything, so that force at given stretch says nothing there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/fit/fit_model.h"
#include "tools/fit/measurements.h"

namespace umax {

/// A value with its 95 % confidence interval.
struct Estimate {
  double value = 0, low = 0, high = 0;
};

struct MaterialFit {
  Estimate young;                   // [Pa]
  std::optional<Estimate> limit;    // [-] limit.stretch; nothing where the data do not reach one
  double limit_bound = 0;           // [-] then the limit is at least this, with 95 % confidence
  std::optional<Estimate> poisson;  // [-] nothing where the data do not tell it
  double assumed_poisson = 0.3;     // [-] what was taken instead

  int points_at_limit = 0;
  std::vector<double> stretch;          // [-] of the simulated specimen at each point's force
  std::vector<double> lateral_stretch;  // [-] likewise; empty without measured ones
  double rms = 0;                       // [-] of stretch measured less simulated
  std::size_t worst = 0;                // the point that is farthest off
  std::vector<std::string> warnings;

  double used_poisson() const { return poisson ? poisson->value : assumed_poisson; }
};

/// Simulates the test on hexes (tools/fit/specimen.h) and adjusts the material to the measurements. poisson: [-] taken
/// where no lateral stretches are measured. Throws Error (bad_data) where they do not tell Young's modulus, or where
/// the specimen does not bear what was measured.
MaterialFit fit_material(const Measurements& measurements, double poisson);
/// The same with specimens that are kept for further fits; the model's test must be the measurements'.
MaterialFit fit_material(const Measurements& measurements, double poisson, FitModel& model);

/// Stretches (and lateral stretches, NaN in shear) of simulated specimens under nominal stresses [Pa].
struct SimulatedTest {
  std::vector<double> stretch, lateral_stretch;
};
SimulatedTest simulate_test(TestKind test, double young, double poisson, double limit_stretch,
                            const std::vector<double>& stresses);

}  // namespace umax
