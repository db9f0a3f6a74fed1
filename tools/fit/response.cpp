#include "tools/fit/response.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr double spacing = 0.025;    // [-] of loads
constexpr double largest_load = 12;  // [-] a stretch of 1200 %: beyond any use
constexpr double grid_step = 0.2;    // of the logarithm of limits whose locking is simulated

/// Cubic through the values at 1 and 2 of four evenly spaced ones, with their central differences as slopes.
double cubic(const std::array<double, 4>& v, double t) {
  const double m1 = (v[2] - v[0]) / 2, m2 = (v[3] - v[1]) / 2;
  const double a = 2 * (v[1] - v[2]) + m1 + m2, b = 3 * (v[2] - v[1]) - 2 * m1 - m2;
  return ((a * t + b) * t + m1) * t + v[1];
}

}  // namespace

Response::Response(Loading loading, double poisson)
    : loading_(loading), poisson_(poisson), specimen_({.loading = loading, .poisson = poisson}) {}

bool Response::add_knot() {
  const double load = double(knots_.size()) * spacing;
  const auto reading = complete_ || load > largest_load ? std::nullopt : specimen_.at(load);
  complete_ = !reading || !(reading->peak_stretch > knots_.back().peak_stretch);
  if (!complete_) knots_.push_back(*reading);
  return !complete_;
}

bool Response::cover(double load) {
  // one knot more than the interval needs, where there is one
  while (knots_.size() < 3 || double(knots_.size() - 2) * spacing < load)
    if (!add_knot()) break;
  return double(knots_.size() - 1) * spacing >= load;
}

bool Response::cover_peak(double peak_stretch) {
  while (knots_.back().peak_stretch < peak_stretch)
    if (!add_knot()) return false;
  add_knot();
  return true;
}

SpecimenReading Response::unlimited(double load) const {
  const int last = int(knots_.size()) - 1;
  const int interval = std::clamp(int(load / spacing), 0, last - 1);
  const double t = load / spacing - interval;
  const auto value = [&](double SpecimenReading::* member) {
    const auto knot = [&](int i) { return knots_[std::size_t(i)].*member; };
    // the curve goes on as a parabola at its last knot, and through the origin as an odd function (peak: likewise)
    const double before = interval > 0 ? knot(interval - 1) : -knot(1);
    const double after =
        interval + 2 <= last ? knot(interval + 2) : 3 * knot(interval + 1) - 3 * knot(interval) + before;
    return cubic({before, knot(interval), knot(interval + 1), after}, t);
  };
  return {value(&SpecimenReading::stretch), value(&SpecimenReading::lateral_stretch),
          value(&SpecimenReading::peak_stretch)};
}

std::optional<double> Response::onset(double limit_stretch) {
  if (last_limit_ != limit_stretch) {
    last_onset_ = find_onset(limit_stretch);
    last_limit_ = limit_stretch;
  }
  return last_onset_;
}

std::optional<double> Response::find_onset(double limit_stretch) {
  if (!(limit_stretch < no_limit) || !cover_peak(limit_stretch)) return std::nullopt;
  const auto next = std::lower_bound(knots_.begin() + 1, knots_.end(), limit_stretch,
                                     [](const SpecimenReading& knot, double peak) { return knot.peak_stretch < peak; });
  double low = double(next - knots_.begin() - 1) * spacing, high = low + spacing;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (unlimited(middle).peak_stretch < limit_stretch ? low : high) = middle;
  }
  return (low + high) / 2;
}

const Response::Locking& Response::locking(int grid_limit) {
  const auto known = locking_.find(grid_limit);
  if (known != locking_.end()) return known->second;
  Locking& locking = locking_[grid_limit];
  const double limit = std::exp(grid_step * grid_limit);
  const auto start = onset(limit);
  if (!start) return locking;
  Specimen specimen({.loading = loading_, .poisson = poisson_, .limit_stretch = limit});
  const double stretch = unlimited(*start).stretch;
  for (const double excess : excess_loads) {
    const auto reading = excess == 1 ? unlimited(*start) : specimen.at(excess * *start);
    if (!reading) return locking = {};
    locking.push_back(reading->stretch / stretch);
  }
  return locking;
}

std::optional<double> Response::locking_at(double excess, double limit_stretch) {
  const double place = std::log(limit_stretch) / grid_step;
  const int below = int(std::floor(place));
  const auto read = [&](const Locking& curve) {
    const double clamped = std::min(excess, excess_loads.back());
    const auto next = std::max<std::size_t>(
        1, std::size_t(std::lower_bound(excess_loads.begin(), excess_loads.end(), clamped) - excess_loads.begin()));
    const double t = (clamped - excess_loads[next - 1]) / (excess_loads[next] - excess_loads[next - 1]);
    return (1 - t) * curve[next - 1] + t * curve[next];
  };
  const Locking &low = locking(below), &high = locking(below + 1);
  if (low.empty()) return std::nullopt;
  if (high.empty()) return read(low);
  return (below + 1 - place) * read(low) + (place - below) * read(high);
}

std::optional<SpecimenReading> Response::at(double load, double limit_stretch) {
  const auto start = onset(limit_stretch);
  if (!start || load <= *start) {
    if (!cover(load)) return std::nullopt;
    return unlimited(load);
  }
  const auto factor = locking_at(load / *start, limit_stretch);
  if (!factor) return std::nullopt;
  SpecimenReading reading = unlimited(*start);
  reading.stretch *= *factor;
  reading.lateral_stretch *= *factor;
  return reading;
}

}  // namespace umax
