#include "render/trace/caught_light.h"

#include <algorithm>

namespace umax {

CaughtLight::CaughtLight(const RenderScene& scene, int left, int top) : left_(left), top_(top) {
  const auto catches = [](const RenderObject& object) { return object.catches_shadows; };
  if (std::none_of(scene.objects.begin(), scene.objects.end(), catches)) return;
  for (const RenderObject& object : scene.objects) catches_.push_back(catches(object) ? 1 : 0);
  pixels_.resize(std::size_t(extent) * extent);
}

void CaughtLight::add(int column, int row, const PathStart& start, const FirstPart& met, const Vector3f& radiance) {
  Sum& sum = pixels_[std::size_t(row - top_) * extent + std::size_t(column - left_)][std::size_t(start.stream)];
  const bool is_even = start.sample % 2 == 0;
  ++sum.paths;
  sum.num_even += is_even;
  if (met.object == Hit::nothing || !catches_[met.object]) return;
  ++sum.caught;
  sum.light += radiance.cast<double>();
  if (is_even) sum.even += radiance.cast<double>();
}

void CaughtLight::store(TracedImage& image) const {
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const auto& [a, b] = pixels_[i];
    const int x = left_ + int(i) % extent, y = top_ + int(i) / extent;
    if (a.paths == 0) continue;  // beyond the picture's edge
    Eigen::Vector3d light = a.light / a.paths, half = a.even / std::max(a.num_even, 1);
    double share = double(a.caught) / a.paths;
    if (b.paths > 0) {  // two halves that count as much as each other
      half = light;
      light = (light + b.light / b.paths) / 2;
      share = (share + double(b.caught) / b.paths) / 2;
    }
    for (int c = 0; c < 3; ++c) {
      image.caught->light.pixel(x, y)[c] = float(light[c]);
      image.caught->half.pixel(x, y)[c] = float(half[c]);
    }
    *image.caught->share.pixel(x, y) = float(share);
  }
}

}  // namespace umax
