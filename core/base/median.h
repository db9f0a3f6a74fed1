// The middle of several numbers.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace umax {

/// The upper one of an even count; of one value at least.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace umax
