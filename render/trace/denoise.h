// Takes the noise out of a path-traced picture of few samples, guided by what was seen: albedo, normal, depth,
// variance.
#pragma once

#include "render/trace/path_trace.h"

namespace umax {

struct DenoiseOptions {
  float strength = 1;  // [-] scales the noise that is taken to be there; 0 leaves the picture as it is
};

/// The filtered colour. Edges of surfaces, textures and shadows stay where they are; values do not depend on the number
/// of threads. The layers must be of one size (as path_trace() makes them).
Image denoise(const TracedImage& traced, const DenoiseOptions& options = {});

}  // namespace umax
