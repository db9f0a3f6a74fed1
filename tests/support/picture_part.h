// Whether a picture that was traced alone is what the whole picture shows there.
#pragma once

#include <algorithm>

#include "render/image/image.h"
#include "render/trace/path_trace.h"

namespace umax::test {

/// Has `part` the crop's size, and the bits that `whole` has there?
inline bool is_part_of(const Image& whole, const Crop& crop, const Image& part) {
  const int width = crop.x1 - crop.x0, height = crop.y1 - crop.y0;
  if (part.width != width || part.height != height || part.channels != whole.channels) return false;
  for (int y = 0; y < height; ++y)
    if (!std::equal(part.pixel(0, y), part.pixel(0, y) + width * part.channels, whole.pixel(crop.x0, crop.y0 + y)))
      return false;
  return true;
}

}  // namespace umax::test
