#include "render/trace/caught_light.h"

#include <algorithm>

namespace umax {

CaughtLight::CaughtLight(const RenderScene& scene, int left, int top) : left_(left), top_(top) {
  const auto catches = [](const RenderObject& object) { return object.catches_shadows; };
  if (std::none_of(scene.objects.begin(), scene.objects.end(), catches)) return;
  for (const RenderObject& object : scene.objects) catches_.push_back(catches(object) ? 1 : 0);
  pixels_.resize(std::size_t(extent) * extent);
}

void CaughtLight::add(int column, int row, const PathStart& start, const FirstPart& met, const PathResult& path) {
  Sum& sum = pixels_[std::size_t(row - top_) * extent + std::size_t(column - left_)][std::size_t(start.stream)];
  const bool is_even = start.sample % 2 == 0;
  ++sum.paths;
  sum.num_even += is_even;
  if (met.object == Hit::nothing || !catches_[met.object]) return;
  ++sum.caught;
  sum.albedo += path.albedo.cast<double>();
  sum.normal += path.normal.cast<double>();
  sum.depth += double(path.depth);
  sum.light += path.radiance.cast<double>();
  if (is_even) sum.even += path.radiance.cast<double>();
}

void CaughtLight::store(TracedImage& image) const {
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const auto& [a, b] = pixels_[i];
    if (a.paths == 0) continue;  // beyond the picture's edge
    const int x = left_ + int(i) % extent, y = top_ + int(i) / extent;
    // of two halves each counts as much as the other
    const auto mean = [&sums = pixels_[i]](auto member) {
      auto value = member(sums[0]);
      value /= sums[0].paths;
      if (sums[1].paths == 0) return value;
      auto other = member(sums[1]);
      other /= sums[1].paths;
      value += other;
      value /= 2;
      return value;
    };
    const auto store = [&](Image& to, const Eigen::Vector3d& value) {
      for (int c = 0; c < 3; ++c) to.pixel(x, y)[c] = float(value[c]);
    };
    CaughtImage& caught = *image.caught;
    store(caught.light, mean([](const Sum& sum) { return sum.light; }));
    store(caught.half, b.paths > 0 ? a.light / a.paths : a.even / std::max(a.num_even, 1));
    store(caught.albedo, mean([](const Sum& sum) { return sum.albedo; }));
    store(caught.normal, mean([](const Sum& sum) { return sum.normal; }));
    *caught.depth.pixel(x, y) = float(mean([](const Sum& sum) { return sum.depth; }));
    *caught.share.pixel(x, y) = float(mean([](const Sum& sum) { return double(sum.caught); }));
  }
}

}  // namespace umax
