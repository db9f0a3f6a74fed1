// A value over time, given by keys: linear, smooth or held in between, constant before the first and after the last.
#pragma once

#include <algorithm>
#include <cassert>
#include <vector>

namespace umax {

enum class Interpolation { linear, smooth, hold };

/// Keyframed value. T needs + and multiplication by double. A constant is one key at time 0.
template <class T>
struct Track {
  std::vector<double> times;  // [s] strictly increasing
  std::vector<T> values;      // one per time
  Interpolation interpolation = Interpolation::linear;

  Track() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a constant is a track
  Track(const T& constant) : times{0.0}, values{constant} {}

  bool is_constant() const { return values.size() == 1; }
  bool operator==(const Track&) const = default;

  /// Value at time [s]. "smooth" eases in and out of every key with 3s^2 - 2s^3; "hold" is the last key's until the next.
  T at(double time) const {
    assert(!values.empty() && values.size() == times.size());
    if (time <= times.front()) return values.front();
    if (time >= times.back()) return values.back();
    const auto next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
    if (interpolation == Interpolation::hold) return values[next - 1];
    double s = (time - times[next - 1]) / (times[next] - times[next - 1]);
    if (interpolation == Interpolation::smooth) s = s * s * (3.0 - 2.0 * s);
    return T(values[next - 1] * (1.0 - s) + values[next] * s);
  }
};

}  // namespace umax
