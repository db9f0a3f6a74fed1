// What a picture's pixels show, as numbers for a compositor: one ray through the middle of each pixel, nothing averaged.
#pragma once

#include "render/trace/ray_scene.h"

namespace umax {

inline constexpr float depth_of_nothing = 1e10f;  // [m] as Cycles has it

/// All of one size; 0 where nothing is seen, but for the depth.
struct SurfaceData {
  Image depth;     // 1: distance from the plane through the camera, across its line of sight [m]
  Image position;  // 3: [m] world
  Image
      motion;  // 4: [px] right and up. From where the point was one frame before to where it is, negated; and likewise
               // from where it is to where it will be one frame later: what Cycles calls Vector
  Image object;  // 1: 1 + its place in RenderScene::objects
  Image value;   // 1: of RenderObject::values
};

/// At the scene's moment, through the middle of the lens. The values do not depend on the number of threads.
SurfaceData find_surface_data(const RayScene& rays, const RenderScene& scene, int width, int height);

}  // namespace umax
