#include "render/trace/tile_parts.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstdint>

namespace umax {
namespace {

struct Share {
  float number = 0;
  double share = 0;
};

void add_share(std::vector<Share>& shares, float number, double share) {
  const auto is_same = [&](const Share& other) {
    return std::bit_cast<std::uint32_t>(other.number) == std::bit_cast<std::uint32_t>(number);
  };
  const auto found = std::find_if(shares.begin(), shares.end(), is_same);
  if (found == shares.end())
    shares.push_back({number, share});
  else
    found->share += share;
}

void store_ranks(std::vector<Share>& shares, float* pixel) {
  std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
    return a.share != b.share ? a.share > b.share : a.number < b.number;
  });
  for (std::size_t rank = 0; rank < std::min<std::size_t>(shares.size(), matte_ranks); ++rank) {
    pixel[2 * rank] = shares[rank].number;
    pixel[2 * rank + 1] = float(shares[rank].share);
  }
}

}  // namespace

TileParts::TileParts(const std::vector<TracedObject>& objects, const std::vector<PartNumbers>& mattes, int left,
                     int top)
    : objects_(objects), mattes_(mattes), left_(left), top_(top) {
  if (are_wanted()) pixels_.resize(std::size_t(extent) * extent);
}

void TileParts::add(int column, int row, int half, const FirstPart& met) {
  assert(column >= left_ && column < left_ + extent && row >= top_ && row < top_ + extent);
  Pixel& pixel = pixels_[std::size_t(row - top_) * extent + std::size_t(column - left_)];
  ++pixel.paths[std::size_t(half)];
  if (met.object == Hit::nothing) return;
  const TracedObject& object = objects_[met.object];
  const unsigned paint = object.paint.empty() ? 0 : unsigned(object.paint[met.triangle]);
  const auto is_same = [&](const Part& part) { return part.object == met.object && part.paint == paint; };
  auto found = std::find_if(pixel.parts.begin(), pixel.parts.end(), is_same);
  if (found == pixel.parts.end()) found = pixel.parts.insert(found, {.object = met.object, .paint = paint});
  ++found->paths[std::size_t(half)];
}

void TileParts::store(TracedImage& image) const {
  std::vector<Share> shares;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& pixel = pixels_[i];
    const int halves = pixel.paths[1] > 0 ? 2 : 1;  // each counts as much as the other
    for (std::size_t m = 0; m < mattes_.size() && !pixel.parts.empty(); ++m) {
      shares.clear();
      for (const Part& part : pixel.parts) {
        double share = 0;
        for (int h = 0; h < halves; ++h) share += double(part.paths[h]) / pixel.paths[h] / halves;
        add_share(shares, mattes_[m][part.object][part.paint], share);
      }
      store_ranks(shares, image.mattes[m].pixel(left_ + int(i) % extent, top_ + int(i) / extent));
    }
  }
}

}  // namespace umax
