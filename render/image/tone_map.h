// From scene-linear light to the 8-bit sRGB that a screen shows: exposure, a filmic curve, gamut.               [Lot16]
// Curve per channel, after T. Lottes, "Advanced Techniques and Optimization of HDR Color Pipelines", GDC 2016:
//
//   y = x^a / (x^(a d) b + c)
//
// x: linear light, y: shown, both relative to white [-];  a: contrast in the mid tones;  d: how hard the shoulder bends
// b, c: such that mid grey stays where it is asked to and `white` becomes 1
// Before the curve the channels are mixed a little, so that bright saturated light runs to white instead of a primary;
// after it the mixing is undone and the saturation raised.
#pragma once

#include "render/image/image.h"

namespace umax {

enum class ToneCurve {
  filmic,    // contrast and a shoulder: for pictures to be looked at
  standard,  // the plain sRGB curve, clipped: for comparisons and data
};

struct ToneMapOptions {
  ToneCurve curve = ToneCurve::filmic;
  float exposure_stops = 0;  // [EV] the light is multiplied by 2^stops
  float contrast = 1.32f;    // [-] a; more: darker shadows, steeper mid tones
  float white = 8.0f;        // [-] this linear value and all above become white; more: softer highlights
  float saturation = 1.12f;  // [-] after the curve
};

/// What the screen shows of grey light: relative to white, before the sRGB curve, for questions of how visible a
/// difference is.
class ShownLuminance {
 public:
  explicit ShownLuminance(const ToneMapOptions& options);
  float operator()(float luminance) const;

 private:
  ToneMapOptions options_;
  float scale_, b_, c_;
};

/// 8-bit sRGB of a scene-linear picture; alpha (a 4th channel) is kept. Deterministic, no dithering.
Image8 tone_map(const Image& linear, const ToneMapOptions& options = {});

}  // namespace umax
