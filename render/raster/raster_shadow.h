// Depth maps as lights see the scene, drawn in parallel by the processor: far quicker for many small maps than GL.
#pragma once

#include <vector>

#include "render/raster/raster_frame.h"

namespace umax::raster {

/// One map of size x size depths in [0, 1] per sample (1: nothing), rows from below, one after the other. Everything
/// but the ground casts; triangles that reach behind a light are left out. The same bits for every number of threads.
std::vector<float> draw_shadow_maps(const Frame& frame, const std::vector<LightSample>& samples, int size);

}  // namespace umax::raster
