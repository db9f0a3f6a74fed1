// How many paths a pixel needs for a noise that is asked for. A pixel's paths are two halves that know nothing of each
// other: the first paths of one tell how many the other needs. So neither half's number depends on its own values, and
// the mean of both halves' means is the light that all paths would give on the average: nothing is biased.
#pragma once

#include "render/image/tone_map.h"
#include "render/trace/pixel_sum.h"

namespace umax {

class EnoughSamples {
 public:
  /// noise: standard error of the pixel's luminance as shown, over its value; samples: the most that a pixel gets.
  EnoughSamples(double noise, int samples, float exposure_stops);

  int most() const { return most_; }    // of one half
  int first() const { return first_; }  // of one half: what tells
  /// How many one half needs, told by the first paths of the other.
  int needed(const PixelSum& other) const;

 private:
  double noise_;
  int most_, first_;
  ShownLuminance shown_;
};

}  // namespace umax
