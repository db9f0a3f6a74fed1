#include "render/trace/surface_data.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"
#include "render/scene/camera.h"

namespace umax {
namespace {

// the corners' share of a point on a triangle
struct Corners {
  std::array<unsigned, 3> index;
  std::array<float, 3> weight;
};

Corners corners_of(const TracedObject& object, const Hit& hit) {
  const auto& index = object.triangles[hit.triangle].index;
  return {{index[0], index[1], index[2]}, {1 - hit.u - hit.v, hit.u, hit.v}};
}

Vector3f position_on(const TriangleMesh& mesh, const Corners& corners) {
  Vector3f position(0, 0, 0);
  for (int c = 0; c < 3; ++c)
    position += corners.weight[c] * mesh.positions.row(corners.index[c]).transpose().cast<float>();
  return position;
}

class Looker {
 public:
  Looker(const RayScene& rays, const RenderScene& scene, int width, int height)
      : rays_(rays), scene_(scene), now_(view_at_moment(scene, width, height)), previous_(now_), next_(now_) {
    if (scene.previous_camera) previous_ = Projection(make_camera_view(*scene.previous_camera, width, height));
    if (scene.next_camera) next_ = Projection(make_camera_view(*scene.next_camera, width, height));
  }

  Ray ray_through(int x, int y) const {
    CameraView pinhole = now_.view;
    pinhole.aperture_radius = 0;
    Ray ray = camera_ray(pinhole, float(x) + 0.5f, float(y) + 0.5f, {0, 0});
    ray.time = scene_.moment;
    return ray;
  }

  void store(const Hit& hit, int x, int y, SurfaceData& data) const {
    const TracedObject& traced = rays_.objects()[hit.object];
    const RenderObject& object = scene_.objects[hit.object];
    const Corners corners = corners_of(traced, hit);
    const Vector3f position = traced.position_on(hit, scene_.moment);
    *data.depth.pixel(x, y) = now_.depth(position);
    *data.object.pixel(x, y) = float(hit.object + 1);
    std::copy_n(position.data(), 3, data.position.pixel(x, y));
    store_motion(object, corners, position, data.motion.pixel(x, y));
    if (object.values.empty()) return;
    float value = 0;
    for (int c = 0; c < 3; ++c) value += corners.weight[c] * object.values[corners.index[c]];
    *data.value.pixel(x, y) = value;
  }

 private:
  void store_motion(const RenderObject& object, const Corners& corners, const Vector3f& position, float* motion) const {
    const Vector3f before = object.previous ? position_on(*object.previous, corners) : position,
                   after = object.next ? position_on(*object.next, corners) : position;
    const Vector2f here = now_.place(position);
    const Vector2f from = previous_.place(before) - here, onwards = here - next_.place(after);
    // what comes from behind the camera, or goes there, has no place in the picture
    const bool came = previous_.depth(before) > 0, stays = next_.depth(after) > 0;
    for (int c = 0; c < 2; ++c) {
      motion[c] = came ? from[c] : 0;
      motion[2 + c] = stays ? onwards[c] : 0;
    }
  }

  const RayScene& rays_;
  const RenderScene& scene_;
  Projection now_, previous_, next_;
};

}  // namespace

SurfaceData find_surface_data(const RayScene& rays, const RenderScene& scene, int width, int height) {
  SurfaceData data{.depth = Image(width, height, 1),
                   .position = Image(width, height, 3),
                   .motion = Image(width, height, 4),
                   .object = Image(width, height, 1),
                   .value = Image(width, height, 1)};
  std::fill(data.depth.values.begin(), data.depth.values.end(), depth_of_nothing);
  const Looker looker(rays, scene, width, height);
  parallel_blocks(height, 8, [&](Eigen::Index begin, Eigen::Index end) {
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < width; ++x)
        if (const Hit hit = rays.intersect(looker.ray_through(x, y)); hit.found()) looker.store(hit, x, y, data);
  });
  return data;
}

}  // namespace umax
