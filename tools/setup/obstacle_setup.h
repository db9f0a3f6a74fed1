// Obstacles from a scene: shapes, meshes, and meshes that are animated.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/model/model.h"
#include "scenes/scene.h"
#include "tools/setup/body_shape.h"

namespace umax {

struct ObstacleSetup {
  std::shared_ptr<const TriangleMesh> mesh;  // at rest, in the obstacle's own frame [m]; null: a half space
  std::vector<std::string> notes;            // for the user: what contact will not feel of it
  Look look;                                 // as it can be drawn
};

/// The model's obstacle and the mesh to draw it. clip: for what is animated. Throws Error naming the obstacle.
Obstacle make_obstacle(const ObstacleDescription& description, const ClipDescription& clip, ObstacleSetup& setup,
                       ShapeLibrary& library);

/// Says which animations are so fast that steps are halved where they meet a body.
void warn_of_fast_animations(const Model& model, double time_step, std::vector<std::string>& warnings);

}  // namespace umax
