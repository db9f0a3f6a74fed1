// Lights what the rasteriser sees: soft shadows from many maps, highlights, mirrored surroundings, the ground's
// horizon.
#pragma once

#include "render/raster/raster_frame.h"

namespace umax::raster {

/// Scene-linear RGB picture; each pixel is the mean of its samples' surfaces, each surface shaded once. The same bits
/// for every number of threads.
Image shade(const Frame& frame, const Visible& visible);

}  // namespace umax::raster
