// What covers its pixels only in part: pictures with alpha, and surfaces that are not seen but for the shadows on them, both
// for laying over a filmed picture.
//
//   shadow = 1 - L / L0      alpha = share of what is seen + share of the catchers * shadow
//
// L: luminance of a catcher as it is;  L0: with no other objects in the scene. Both are traced, with the same paths: where
// nothing is near they are equal to the last bit. What objects reflect onto a catcher makes it no brighter than L0.
#pragma once

#include "render/trace/path_trace.h"

namespace umax {

/// The scene as finish_cut_out() wants it traced.
RenderScene made_transparent(RenderScene scene);

/// Turns catchers into their shadows and, where `denoised`, takes the noise out of light and shadows. traced: of
/// made_transparent(scene), with these options. Its colour is then premultiplied by its alpha, and lies over sky or
/// backdrop unless the scene is transparent. Throws as path_trace().
void finish_cut_out(const RenderScene& scene, const PathTraceOptions& options, bool denoised, TracedImage& traced);

}  // namespace umax
