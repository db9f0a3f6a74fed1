// Which parts of the scene the pixels of a tile show, counted in paths.
#pragma once

#include <array>
#include <vector>

#include "render/trace/path_trace.h"
#include "render/trace/path_wave.h"

namespace umax {

/// Counts, and then ranks, what the first surface of each path belongs to. Does nothing where no mattes are wanted.
class TileParts {
 public:
  /// left, top: of the tile, in pixels of what is kept.
  TileParts(const std::vector<TracedObject>& objects, const std::vector<PartNumbers>& mattes, int left, int top);

  bool are_wanted() const { return !mattes_.empty(); }
  /// A path of one of the two halves that a pixel's paths may be.
  void add(int column, int row, int half, const FirstPart& met);
  /// Puts the ranks into image.mattes.
  void store(TracedImage& image) const;

 private:
  static constexpr int extent = 16;  // [px] at most
  struct Part {
    unsigned object, paint;
    std::array<int, 2> paths{};  // of each half
  };
  struct Pixel {
    std::vector<Part> parts;
    std::array<int, 2> paths{};  // those that met nothing, too
  };
  const std::vector<TracedObject>& objects_;
  const std::vector<PartNumbers>& mattes_;
  int left_, top_;
  std::vector<Pixel> pixels_;
};

}  // namespace umax
