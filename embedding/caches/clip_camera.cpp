#include <Eigen/Geometry>

#include "embedding/caches/moving_surface.h"

namespace umax {

CameraAxes axes_of(const ClipCamera& camera) {
  CameraAxes axes;
  axes.back = (camera.position - camera.target).normalized();
  axes.right = camera.up.cross(axes.back).normalized();
  axes.up = axes.back.cross(axes.right);
  return axes;
}

}  // namespace umax
