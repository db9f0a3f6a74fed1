// Takes the noise out of a path-traced picture of few samples, guided by what was seen: albedo, normal, depth,
// variance.
#pragma once

#include "render/trace/noisy_light.h"

namespace umax {

struct DenoiseOptions {
  float strength = 1;  // [-] scales the noise that is taken to be there; 0 leaves the picture as it is
  int radius = 7;      // [px] of the window that a pixel draws from, at most 7; less is faster, and leaves more noise
};

/// The filtered colour. Edges of surfaces, textures and shadows stay where they are; values do not depend on the number
/// of threads. The layers must be of one size (as path_trace() makes them).
Image denoise(const TracedImage& traced, const DenoiseOptions& options = {});

/// The same from light that was gathered elsewhere, on the surfaces that albedo, normal and depth of `guides` tell.
Image denoise(const TracedImage& guides, const NoisyLight& light, const DenoiseOptions& options = {});

}  // namespace umax
