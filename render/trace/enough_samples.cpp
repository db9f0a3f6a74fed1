#include "render/trace/enough_samples.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr int least_first = 8;         // fewer tell too little
constexpr double darkest = 0.01;       // of white: what is darker need not be more exact than this
constexpr double overstatement = 2.0;  // the paths' variance over that of their well spread mean

}  // namespace

EnoughSamples::EnoughSamples(double noise, int samples, float exposure_stops)
    : noise_(noise),
      most_((samples + 1) / 2),
      first_(std::clamp(most_ / 8, std::min(least_first, most_), most_)),
      shown_(ToneMapOptions{.exposure_stops = exposure_stops}) {}

int EnoughSamples::needed(const PixelSum& other) const {
  const double of_path = other.variance_of_mean() * other.count / overstatement;
  if (!(of_path > 0)) return first_;
  // how much light may be wrong, from the slope of the screen's curve
  const double light = other.mean_luminance(), step = 0.01 * light + 1e-6;
  const double shown = double(shown_(float(light)));
  const double slope = (double(shown_(float(light + step))) - double(shown_(float(light - step)))) / (2 * step);
  const double allowed = noise_ * std::max(shown, darkest) / std::max(slope, 1e-9);
  const double count = std::ceil(of_path / (2 * allowed * allowed));
  return int(std::clamp(count, double(first_), double(most_)));
}

}  // namespace umax
