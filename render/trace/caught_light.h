// The light of paths whose first surface catches shadows, told apart from that of all others, for the pixels of a tile.
#pragma once

#include <array>
#include <vector>

#include "render/trace/path_trace.h"
#include "render/trace/path_wave.h"

namespace umax {

/// Does nothing where nothing catches shadows.
class CaughtLight {
 public:
  /// left, top: of the tile, in pixels of what is kept.
  CaughtLight(const RenderScene& scene, int left, int top);

  bool is_wanted() const { return !catches_.empty(); }
  /// A path of one of the two halves that a pixel's paths may be.
  void add(int column, int row, const PathStart& start, const FirstPart& met, const PathResult& path);
  /// Puts the means into image.caught, if that is there.
  void store(TracedImage& image) const;

 private:
  static constexpr int extent = 16;  // [px] at most
  struct Sum {
    Eigen::Vector3d light{0, 0, 0}, even{0, 0, 0};  // of all of its paths, of those of even samples
    Eigen::Vector3d albedo{0, 0, 0}, normal{0, 0, 0};
    double depth = 0;
    int caught = 0, paths = 0, num_even = 0;
  };
  std::vector<char> catches_;  // of each object
  int left_, top_;
  std::vector<std::array<Sum, 2>> pixels_;
};

}  // namespace umax
