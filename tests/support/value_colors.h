// Looks for the colours of values in pictures.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "render/image/colormap.h"

namespace umax {

/// Pixels from a column on whose codes differ by at most 3 from the value's colour.
inline int num_of_color(const Image8& image, double value, int first_column = 0) {
  const auto code = code_of_value(value);
  const auto near = [](int a, int b) { return std::abs(a - b) <= 3; };
  int count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = first_column; x < image.width; ++x)
      count += std::equal(code.data(), code.data() + 3, image.pixel(x, y), near);
  return count;
}

}  // namespace umax
