// FLIP: how different two pictures look when one alternates between them, per pixel in [0, 1].                 [ANA*20]
// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating
// Images", HPG 2020.
//
//   delta = delta_colour^(1 - delta_feature)
//
// delta_colour: contrast-sensitivity filters in a linear opponent space, Hunt-adjusted CIELAB, HyAB distance,
// compressed to [0, 1];  delta_feature: edges and points of the lightness, in [0, 1]
#pragma once

#include "render/image/image.h"

namespace umax {

struct FlipOptions {
  float pixels_per_degree = 67.0206f;  // [1/deg] 0.7 m from a 0.7 m wide screen of 3840 pixels; more: less is seen
  double threshold = 0.1;              // [-] what percent_above counts
};

struct FlipResult {
  double mean = 0, maximum = 0;  // [-] 0: the same, 1: as different as can be
  double percent_above = 0;      // [%] of the pixels lie above FlipOptions::threshold
  Image map;                     // #H x #W x 1 the difference per pixel
};

/// Difference of two pictures of one size, with sRGB values in [0, 1] (not linear; others are clipped); only the first
/// three channels count, grey stands for all three. Throws Error 65 when the sizes differ.
FlipResult flip(const Image& reference, const Image& test, const FlipOptions& options = {});
FlipResult flip(const Image8& reference, const Image8& test, const FlipOptions& options = {});

}  // namespace umax
