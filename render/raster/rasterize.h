// The quick preview: the path tracer's scenes drawn by a rasteriser with soft shadows, sky light and reflections.
//
// Lights are sampled by points and the sky by directions, each with a shadow map of its own, so that penumbras and the
// darkening near contacts come out as in a path-traced picture with one bounce. Reflections look the surroundings up,
// not the scene. Four samples a pixel; wires are drawn as exact quads.
#pragma once

#include <memory>

#include "render/scene/render_scene.h"

namespace umax {

struct RasterizeOptions {
  int width = 1280, height = 720;  // [px]
  int supersample = 1;     // [1, 4] pixels drawn per pixel and axis; 2 calms fine wires and highlights, costs 4 times
  int light_samples = 40;  // [1, 128] shadow maps per area light or sun; more: smoother penumbras
  int sky_samples = 44;    // [8, 64] shadow maps of the sky; more: smoother contact shadows
  int threads = 0;         // GL's own threads, fixed by the first picture of the process; 0: all processors
};

/// Throws Error 69 when OSMesa is not there, in the time of loading it.
void require_rasterizer();

/// Draws scenes one after the other with one GL context and its caches. For one thread at a time.
class Rasterizer {
 public:
  /// threads as in RasterizeOptions. Throws Error 69 when there is no OSMesa with GL 4.5.
  explicit Rasterizer(int threads = 0);
  ~Rasterizer();
  Rasterizer(Rasterizer&&) noexcept;
  Rasterizer& operator=(Rasterizer&&) noexcept;

  /// Scene-linear RGB; the same bits for every number of threads. The legend is drawn by present()
  /// (render/annotation/annotate.h).
  Image draw(const RenderScene& scene, const RasterizeOptions& options);

 private:
  struct Resources;
  std::unique_ptr<Resources> resources_;
};

/// One picture; for a clip, keep a Rasterizer.
Image rasterize(const RenderScene& scene, const RasterizeOptions& options);

}  // namespace umax
