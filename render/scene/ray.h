// Rays, and where a ray first meets the scene.
#pragma once

#include <Eigen/Geometry>
#include <limits>

#include "render/image/image.h"

namespace umax {

struct Ray {
  Vector3f origin{0, 0, 0}, direction{0, 0, 1};  // [m], unit
  float max_distance = std::numeric_limits<float>::infinity();
  float time = 0;  // 0: when the shutter opens, 1: when it closes
};

struct Hit {
  static constexpr unsigned nothing = ~0u;
  unsigned object = nothing, triangle = 0;  // index into RenderScene::objects, row of its mesh's triangles
  float distance = 0, u = 0, v = 0;         // [m], barycentric weights of the triangle's second and third corner
  bool found() const { return object != nothing; }
};

}  // namespace umax
