// Turns lights and sky into what the rasteriser can draw: samples with shadow maps, and blurred surroundings.
#pragma once

#include "render/raster/raster_frame.h"
#include "render/scene/render_scene.h"

namespace umax::raster {

/// What shadows are to be seen of.
struct Focus {
  Vector3f center{0, 0, 0};
  float radius = 1;  // [m]
};

/// The horizontal plane that everything stands on, if the scene has one.
struct Ground {
  bool present = false;
  float height = 0;                  // [m]
  Vector3f color{0.5f, 0.5f, 0.5f};  // linear reflectance
};

struct LightingOptions {
  int light_samples = 16, sky_samples = 32;
};

/// Blurred surroundings of one sky, kept from frame to frame: of what is above the ground, and of a ground that sends
/// back 1. What it does send back changes with what stands on it; blurring is linear.
struct ProbeCache {
  Image sharp;
  std::vector<Image> layers, ground_layers;  // the latter empty without ground
};

/// Fills the frame's lights, background and probe. Throws Error 65 when there are more lights than can be drawn.
void prepare_lighting(const RenderScene& scene, const Focus& focus, const Ground& ground,
                      const LightingOptions& options, ProbeCache& cache, Frame& frame);

}  // namespace umax::raster
