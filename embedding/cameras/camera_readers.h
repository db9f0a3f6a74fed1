// What the readers of cameras share.
#pragma once

#include <string_view>
#include <vector>

#include "embedding/cameras/moving_camera.h"

namespace umax::cameras {

/// Of files whose bytes are these.
MovingCamera read_gltf(const std::filesystem::path& path, std::string_view bytes, const std::string& name);
MovingCamera read_usda(const std::filesystem::path& path, std::string_view text, const std::string& name);

/// Throws Error (bad_data) that names the file.
[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what, const std::string& value = {},
                         const std::string& remedy = "export it again");

/// Which of the cameras is meant; each has up to two names.
std::size_t choose(const std::filesystem::path& path, const std::vector<std::vector<std::string>>& names,
                   const std::string& wanted);

/// Numbers over time, `width` of them at each.
struct Samples {
  enum class Between { linear, steps, turns, spline };  // turns: of quaternions (x, y, z, w)
  std::vector<double> times;                            // increasing
  std::vector<double> values;  // width to a time; spline: 3 width, the tangent in, the value, the tangent out
  int width = 1;
  Between between = Between::linear;

  /// Constant before the first and after the last time.
  std::vector<double> at(double time) const;
};

/// From what a camera's node does to points; it looks along -z there, y up.
CameraPlace place_from(const Eigen::Matrix4d& world_from_camera, double vertical_fov_degrees);

}  // namespace umax::cameras
