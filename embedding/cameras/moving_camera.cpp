#include "embedding/cameras/moving_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "embedding/cameras/camera_readers.h"

namespace umax {
namespace cameras {
namespace {

std::string text_of(const std::vector<std::vector<std::string>>& names) {
  std::string text;
  for (const auto& of_one : names) text += (text.empty() ? "" : ", ") + (of_one.empty() ? "?" : of_one.front());
  return text;
}

Eigen::Quaterniond quaternion(const double* v) {
  return Eigen::Quaterniond(v[3], v[0], v[1], v[2]).normalized();
}

/// The third-degree curve of glTF between two values with their tangents [1/s].
std::vector<double> on_spline(const double* before, const double* after, int width, double s, double seconds) {
  const double s2 = s * s, s3 = s2 * s;
  std::vector<double> value;
  for (int c = 0; c < width; ++c) {
    const double tangent_out = before[2 * width + c], tangent_in = after[c];
    value.push_back((2 * s3 - 3 * s2 + 1) * before[width + c] + seconds * (s3 - 2 * s2 + s) * tangent_out +
                    (3 * s2 - 2 * s3) * after[width + c] + seconds * (s3 - s2) * tangent_in);
  }
  return value;
}

}  // namespace

void refuse(const std::filesystem::path& path, const std::string& what, const std::string& value,
            const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = path.string(), .what = what, .value = value, .remedy = remedy});
}

std::size_t choose(const std::filesystem::path& path, const std::vector<std::vector<std::string>>& names,
                   const std::string& wanted) {
  if (names.empty()) refuse(path, "has no camera", "", "export the camera, too");
  if (wanted.empty()) {
    if (names.size() == 1) return 0;
    refuse(path, "has several cameras", text_of(names), "name one in camera.name");
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::find(names[i].begin(), names[i].end(), wanted) != names[i].end()) return i;
  refuse(path, "has no camera of that name", wanted, "camera.name may be one of " + text_of(names));
}

std::vector<double> Samples::at(double time) const {
  const int stride = between == Between::spline ? 3 * width : width, value = between == Between::spline ? width : 0;
  const auto key = [&](std::size_t i) { return values.data() + i * std::size_t(stride); };
  const auto whole = [&](std::size_t i) { return std::vector<double>(key(i) + value, key(i) + value + width); };
  const std::size_t next = std::size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (next == 0) return whole(0);
  if (next == times.size() || between == Between::steps) return whole(next - 1);
  const double seconds = times[next] - times[next - 1], s = (time - times[next - 1]) / seconds;
  if (between == Between::spline) return on_spline(key(next - 1), key(next), width, s, seconds);
  if (between == Between::turns) {
    const Eigen::Quaterniond turn = quaternion(key(next - 1)).slerp(s, quaternion(key(next)));
    return {turn.x(), turn.y(), turn.z(), turn.w()};
  }
  std::vector<double> mixed = whole(next - 1);
  for (int c = 0; c < width; ++c) mixed[std::size_t(c)] += s * (key(next)[c] - mixed[std::size_t(c)]);
  return mixed;
}

CameraPlace place_from(const Eigen::Matrix4d& world_from_camera, double vertical_fov_degrees) {
  CameraPlace place{.vertical_fov_degrees = vertical_fov_degrees};
  place.position = world_from_camera.col(3).head<3>();
  place.forward = -world_from_camera.col(2).head<3>().normalized();
  const Vector3d up = world_from_camera.col(1).head<3>();
  place.up = (up - up.dot(place.forward) * place.forward).normalized();
  return place;
}

namespace {

void require_sensible(const std::filesystem::path& path, const std::string& name, const CameraPlace& place,
                      double time) {
  const auto is_unit = [](const Vector3d& direction) { return std::abs(direction.norm() - 1) < 1e-6; };
  if (!place.position.allFinite() || !is_unit(place.forward) || !is_unit(place.up))
    refuse(path, "has a camera without a place or direction", name + " at " + std::to_string(time) + " s");
  if (!(place.vertical_fov_degrees > 0 && place.vertical_fov_degrees < 180))
    refuse(path, "has a camera without a sensible angle of view",
           std::to_string(place.vertical_fov_degrees) + " degrees at " + std::to_string(time) + " s");
}

}  // namespace
}  // namespace cameras

MovingCamera read_moving_camera(const std::filesystem::path& path, const std::string& name) {
  const std::string bytes = read_file(path);
  const auto begins = [&](std::string_view word) { return bytes.compare(0, word.size(), word) == 0; };
  MovingCamera camera;
  if (begins("#usda"))
    camera = cameras::read_usda(path, bytes, name);
  else if (begins("PXR-USDC") || begins("PK\x03\x04"))
    cameras::refuse(path, "is binary USD", "", "save it as text, .usda");
  else if (begins("glTF") || bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf") == bytes.find('{'))
    camera = cameras::read_gltf(path, bytes, name);
  else
    cameras::refuse(path, "is neither glTF nor USD as text", "", "give a .gltf, .glb or .usda file");
  camera.at = [path, name = camera.name, place_at = std::move(camera.at)](double time) {
    const CameraPlace place = place_at(time);
    cameras::require_sensible(path, name, place, time);
    return place;
  };
  camera.at(camera.start);
  return camera;
}

}  // namespace umax
