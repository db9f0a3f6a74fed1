// An obstacle's triangles whose vertices are animated: what they are at an instant.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/model/mesh_motion.h"
#include "core/model/obstacle.h"
#include "core/model/rest_surface.h"

namespace umax {

/// Remembers the instants that were asked for last: a step asks for its start and its end many times. What they are does
/// not depend on who asks first.
class Deformation {
 public:
  /// at_rest: its triangles count the motion's vertices.
  Deformation(MeshMotion motion, TriangleShape at_rest);

  const MeshMotion& motion() const { return motion_; }

  /// The triangles at a time [s], in the obstacle's own frame.
  std::shared_ptr<const ObstacleShape> shape_at(double time) const;

 private:
  MeshMotion motion_;
  TriangleShape at_rest_;
  mutable std::mutex mutex_;
  mutable std::vector<std::pair<double, std::shared_ptr<const ObstacleShape>>> latest_;  // the newest last
};

}  // namespace umax
