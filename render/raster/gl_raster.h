// Finds what is seen at each sample of a frame, with OpenGL 4.5 on the processor (Mesa's OSMesa). The only place that
// knows GL; the light is added in raster_shade.
#pragma once

#include <memory>

#include "render/raster/raster_frame.h"

namespace umax::raster {

/// Throws Error 69 when OSMesa cannot be loaded.
void require_os_mesa();

/// Owns one GL context with its programs and textures. To be used by one thread at a time.
class GlRaster {
 public:
  /// num_threads: of the GL implementation, set for the whole process by the first one made; 0: as many as there are
  /// processors. Throws Error 69 when there is no OSMesa with GL 4.5.
  explicit GlRaster(int num_threads);
  ~GlRaster();
  GlRaster(const GlRaster&) = delete;
  GlRaster& operator=(const GlRaster&) = delete;

  /// The same bits for every number of threads.
  Visible draw(const Frame& frame);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace umax::raster
