// A noisy picture of a clip with all that tells where its surface points are in the pictures before and after it.
#pragma once

#include <memory>
#include <vector>

#include "render/scene/camera.h"
#include "render/trace/first_hits.h"
#include "render/trace/noisy_light.h"

namespace umax {

/// What a pixel shows: one line of a processor's memory, as pixels are looked up anywhere.
struct alignas(64) SeenPoint {
  float first[3], second[3];       // light of the paths' two halves
  float variance = 0;              // of the luminance of their mean, as the paths tell it
  unsigned object = Hit::nothing;  // in the middle of the pixel
  float distance = 0, slope = 0;   // [m] of that; by how much it changes to the pixels beside. NaN at and beside clear
                                   // matter, through which something else is seen in every frame, and where something
                                   // passes before what stands still: like no other point
  float albedo[3], normal[3];      // means over the pixel
};

struct ClipFrame {
  /// A point on a triangle.
  struct Place {
    unsigned triangle = 0;
    float u = 0, v = 0;
  };
  int width = 0, height = 0;
  bool has_color_noise = false;                               // as TracedImage has it
  Projection projection;                                      // at the frame's moment, through a pinhole
  std::vector<std::shared_ptr<const TriangleMesh>> surfaces;  // where the scene's objects are then
  std::vector<SeenPoint> points;                              // of each pixel, row by row
  std::vector<Place> places;                                  // what the middle of each pixel shows

  const SeenPoint& point(int x, int y) const { return points[std::size_t(y) * width + x]; }
};

/// Of a picture that was traced of the scene. hits: find_first_hits() of it; edges: its find_swept_edges(), or none. The
/// values do not depend on the number of threads.
ClipFrame make_clip_frame(const std::vector<Hit>& hits, const RenderScene& scene, const TracedImage& traced,
                          const std::vector<char>& edges = {});

/// Where the points that one frame shows are in another.
class Reprojection {
 public:
  struct Place {
    float x = 0, y = 0;     // [px] from the upper left corner; the middle of a pixel ends in .5
    float distance = 0;     // [m] from the camera; 0 of what is infinitely far
    bool has_place = true;  // false: behind the camera, or of an object that the other frame has not
  };
  Reprojection(const ClipFrame& from, const ClipFrame& to);

  /// Of what is seen through the middle of a pixel of `from`: the same point of the same triangle.
  Place place(int x, int y) const;
  /// Whether the object stays where it is, and the camera too.
  bool stands_still(unsigned object) const {
    return same_camera_ && (object == Hit::nothing || relations_[object] == Relation::same);
  }

 private:
  enum class Relation { same, moved, other };
  static Relation relation_of(const TriangleMesh& here, const TriangleMesh& there);
  const ClipFrame &from_, &to_;
  bool same_camera_;
  std::vector<Relation> relations_;  // of each object
};

/// The light of the window's frame number `centre` with that of the others, where they show the same points under the
/// same light. Both halves stay independent of each other: each is weighed by what the other tells. The frames must be of
/// one size.
NoisyLight gather_light(const std::vector<const ClipFrame*>& window, std::size_t centre);

}  // namespace umax
