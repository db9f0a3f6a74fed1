// Pictures and what moves: whatever the bytes are, sizes fit and nothing is taken that the file does not hold.
#include <cmath>
#include <cstdint>
#include <cstring>

#include "embedding/caches/point_cache_reader.h"
#include "embedding/cameras/moving_camera.h"
#include "render/image/image_codecs.h"
#include "tests/fuzz/fuzz_target.h"

namespace umax::fuzz {
namespace {

void require_whole(const Image& image) {
  require(image.width > 0 && image.height > 0, "a picture has an extent");
  require(image.channels >= 1 && image.channels <= 4, "a picture has one to four channels");
  require(image.values.size() == std::size_t(image.width) * std::size_t(image.height) * std::size_t(image.channels),
          "a picture has as many numbers as its size says");
}

bool is_pc2(std::string_view bytes) {
  return bytes.starts_with("POINTCACHE2");
}

/// How many vertices the cache says it has, as a mesh that it is of would.
Eigen::Index claimed_vertices(std::string_view bytes) {
  const std::size_t at = is_pc2(bytes) ? 16 : 4;
  std::uint32_t count = 0;
  if (bytes.size() >= at + 4) std::memcpy(&count, bytes.data() + at, 4);
  if (!is_pc2(bytes)) count = __builtin_bswap32(count);
  return std::int32_t(count) < 0 ? 0 : Eigen::Index(count);
}

}  // namespace

void read_picture(std::string_view bytes) {
  accepts([&] {
    const Image image = decode_image(bytes, "picture");
    require_whole(image);
    require(image.channels != 2, "a picture has one, three or four channels");
    if (!codec::is_exr(bytes)) return require_whole(decode_image(bytes, "picture", PngValues::as_stored));
    for (const Layer& layer : codec::decode_exr(bytes, "picture")) require_whole(layer.image);
  });
}

void read_cache(std::string_view bytes) {
  const auto path = as_file(bytes, is_pc2(bytes) ? "cache.pc2" : "cache.mdd");
  accepts([&] {
    const PointSamples samples = read_point_cache(path, claimed_vertices(bytes));
    require(samples.positions.size() == 3 * std::size_t(samples.num_vertices) * samples.times.size(),
            "a cache has the positions of all its vertices at all its times");
    for (std::size_t k = 1; k < samples.times.size(); ++k)
      require(samples.times[k] > samples.times[k - 1], "a cache's times increase");
    require(find_gap(samples.times, 0.01) < int(samples.times.size()), "a gap lies between two of the times");
  });
}

void read_camera(std::string_view bytes) {
  const bool is_text = bytes.starts_with("#usda"), is_binary = bytes.starts_with("glTF");
  const auto path = as_file(bytes, is_text ? "camera.usda" : is_binary ? "camera.glb" : "camera.gltf");
  accepts([&] {
    const MovingCamera camera = read_moving_camera(path, "");
    for (const double later : {-1.0, 0.0, 0.013, 0.5, 1e6}) {
      const CameraPlace place = camera.at(camera.start + later);
      require(place.position.allFinite(), "a camera is somewhere");
      require(std::abs(place.forward.norm() - 1) < 1e-6 && std::abs(place.up.norm() - 1) < 1e-6,
              "a camera's directions are unit vectors");
      require(std::abs(place.forward.dot(place.up)) < 1e-6, "a camera's directions are at right angles");
      require(place.vertical_fov_degrees > 0 && place.vertical_fov_degrees < 180, "a camera sees less than a half");
    }
  });
}

}  // namespace umax::fuzz
