#include "tools/fit/fit_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace umax {
namespace {

// Poisson's ratios of simulated uniaxial specimens. Between them readings are interpolated: at given force the stretch
// does not depend on the ratio, and the lateral stretch is proportional to it.
constexpr std::array simulated_ratios{-0.99, -0.5, -0.2, 0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49, 0.4999};

}  // namespace

Response& FitModel::response(double stress, double poisson) {
  const Loading loading = test_ == TestKind::shear ? Loading::shear
                          : stress < 0             ? Loading::compression
                                                   : Loading::tension;
  return responses_.try_emplace({loading, poisson}, loading, poisson).first->second;
}

std::optional<SpecimenReading> FitModel::simulated(const FitMaterial& material, double poisson, double stress) {
  return response(stress, poisson).at(std::abs(stress) / material.young, material.limit_stretch);
}

std::optional<SpecimenReading> FitModel::at(const FitMaterial& material, double stress) {
  if (test_ == TestKind::shear) {
    auto reading = simulated(material, material.poisson, stress);
    if (reading && stress < 0) reading->stretch = -reading->stretch;
    return reading;
  }
  const double poisson = std::clamp(material.poisson, simulated_ratios.front(), simulated_ratios.back());
  const auto above = std::lower_bound(simulated_ratios.begin() + 1, simulated_ratios.end() - 1, poisson);
  const auto high = simulated(material, *above, stress);
  if (!high || *above == poisson) return high;
  const auto low = simulated(material, *(above - 1), stress);
  if (!low) return std::nullopt;
  const double t = (poisson - *(above - 1)) / (*above - *(above - 1));
  const auto between = [&](double SpecimenReading::* member) { return (1 - t) * *low.*member + t * *high.*member; };
  return SpecimenReading{between(&SpecimenReading::stretch), between(&SpecimenReading::lateral_stretch),
                         between(&SpecimenReading::peak_stretch)};
}

bool FitModel::is_limited(const FitMaterial& material, double stress) {
  const double poisson = test_ == TestKind::shear ? material.poisson : 0.3;  // uniaxial: any
  const auto onset = response(stress, poisson).onset(material.limit_stretch);
  return onset && std::abs(stress) / material.young > *onset;
}

}  // namespace umax
