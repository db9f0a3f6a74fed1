// A camera that another program has animated: read from glTF (.gltf, .glb) and from USD as text (.usda).
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/base/types.h"

namespace umax {

/// Where a camera is and what it sees; metres, y up.
struct CameraPlace {
  Vector3d position{0, 0, 0}, forward{0, 0, -1}, up{0, 1, 0};  // the last two unit and at right angles
  double vertical_fov_degrees = 35;
};

struct MovingCamera {
  std::string name;
  double start = 0;  // [s] where the file's animation begins
  // time: [s] by the file's clock. Throws Error (bad_data) where the camera has no place, direction or angle of view.
  std::function<CameraPlace(double time)> at{};
};

/// The camera of that name (its own, or its node's), or the only one where the name is empty. Throws Error: not_found
/// (no such file), bad_data (damaged, no such camera, several, one that is no perspective).
MovingCamera read_moving_camera(const std::filesystem::path& path, const std::string& name);

}  // namespace umax
