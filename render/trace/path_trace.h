// Pictures by path tracing: what a camera sees of a scene of triangles, area lights and sky, with all light between.
#pragma once

#include <atomic>
#include <functional>
#include <optional>

#include "render/trace/ray_scene.h"

namespace umax {

/// Part of a picture: columns x0 to x1 - 1, rows y0 to y1 - 1.
struct Crop {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // [px]
};

/// A number for each object's paints: [object][paint]. Parts with the same number belong together.
using PartNumbers = std::vector<std::vector<float>>;

constexpr int matte_ranks = 6;  // parts that a pixel tells apart: those it shows most of

struct PathTraceOptions {
  int width = 1280, height = 720;  // [px] of the whole picture
  int samples = 64;                // paths a pixel; powers of two are spread best
  double noise =
      0;  // [-] standard error of a pixel's luminance as the screen shows it, over its value, that is enough:
          // `samples` are then the most; 0: all are taken
  int edge_samples = 0;  // the least that pixels get which `edges` names (with noise 0); 0: as many as all others
  std::vector<char> edges = {};  // of each pixel of the whole picture, as find_edges() has it; or empty: there are none
  int bounces = 4;               // [-] times that light may bounce between surfaces; 0: direct light only
  unsigned seed = 1;             // another seed, other noise
  int block = 0,
      blocks = 1;  // of a sequence that serves this many pictures, the part that is this one's: together they
                   // are spread as well as one picture of all their samples
  std::vector<PartNumbers> mattes = {};          // what pixels show how much of, one way of numbering each
  std::optional<Crop> crop = {};                 // trace only this part: the same values as in the whole picture
  std::function<void(double)> on_progress = {};  // called with the done fraction, from one thread at a time
  const std::atomic<bool>* stop = nullptr;       // becomes true: the rest of the picture stays black
  RayRecording* recording = nullptr;             // receives every ray (for measurements; costs memory)
};

/// The part of a picture that comes from surfaces that catch shadows.
struct CaughtImage {
  Image light, half;            // 3: as TracedImage::color and half, of paths whose first surface is such a one
  Image share;                  // 1: of such paths in all
  Image albedo, normal, depth;  // 3, 3, 1: what they have added to the means over all paths
};

/// A picture and what guides a filter. All of one size (the crop's, if any), all scene-linear.
struct TracedImage {
  Image color;     // 3 channels
  Image albedo;    // 3: reflectance of the first surface, glossy included; the sky's pixels 1
  Image normal;    // 3: shading normal of the first surface, world space; 0 where there is none
  Image depth;     // 1: distance along the ray [m], mean over the paths that met a surface; 0 where none did
  Image variance;  // 1: of the pixel's luminance, estimated from its paths
  Image half;      // 3: colour from half of the paths alone: tells noise from texture
  Image samples;   // 1: paths that were traced
  Image alpha;     // 1: share of the paths that met a surface

  // one per PathTraceOptions::mattes, of 2 matte_ranks channels: pairs of a part's number and the share of the paths that
  // met it first, by falling share; 0 where there are fewer
  std::vector<Image> mattes;
  // 3: variance of each colour, where light enters matter: there colours are noisy by themselves; else empty
  Image color_variance = {};
  bool has_color_noise() const { return !color_variance.values.empty(); }

  std::optional<CaughtImage> caught = {};  // where anything catches shadows: it is shown like anything else
};

/// A picture that is black, and empty in all that guides a filter; without mattes and caught light.
TracedImage black_image(int width, int height);

/// Whether anything in the scene catches shadows.
bool has_shadow_catchers(const RenderScene& scene);

/// Traces a picture. The values do not depend on the number of threads, tiles or the crop. Throws Error 65 for scenes
/// and options that make no picture.
TracedImage path_trace(const RenderScene& scene, const PathTraceOptions& options);

/// The same with a hierarchy that was built before, from the same objects.
TracedImage path_trace(const RayScene& rays, const RenderScene& scene, const PathTraceOptions& options);

}  // namespace umax
