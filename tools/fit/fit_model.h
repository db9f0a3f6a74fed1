// What a test of the simulated specimen would have measured, for any material.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "tools/fit/measurements.h"
#include "tools/fit/response.h"

namespace umax {

struct FitMaterial {
  double young = 1;                 // [Pa]
  double poisson = 0.3;             // [-]
  double limit_stretch = no_limit;  // [-]
};

/// Keeps the specimens that it has simulated.
class FitModel {
 public:
  explicit FitModel(TestKind test) : test_(test) {}

  /// The specimen under a nominal stress [Pa], tension positive. Nothing where it does not bear it.
  std::optional<SpecimenReading> at(const FitMaterial& material, double stress);

  /// Whether some hex is at its limit under the stress.
  bool is_limited(const FitMaterial& material, double stress);

 private:
  Response& response(double stress, double poisson);
  std::optional<SpecimenReading> simulated(const FitMaterial& material, double poisson, double stress);

  TestKind test_;
  std::map<std::pair<Loading, double>, Response> responses_;  // by loading and Poisson's ratio
};

}  // namespace umax
