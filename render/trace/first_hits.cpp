#include "render/trace/first_hits.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "render/scene/camera.h"

namespace umax {
namespace {

constexpr float color_tolerance2 = 0.02f;  // sum of squares over the channels
constexpr float least_cosine = 0.6f;       // of two normals of one surface
constexpr float bend_tolerance = 0.02f;    // of the inverse distance, which is even along planes

// what tells edges
struct EdgeLook {
  unsigned object = Hit::nothing;
  float inverse_distance = 0;
  Vector3f color{0, 0, 0}, normal{0, 0, 0};
};

EdgeLook look_of(const std::vector<TracedObject>& objects, const Hit& hit) {
  if (!hit.found()) return {};
  const TracedObject& object = objects[hit.object];
  const float first = 1 - hit.u - hit.v;
  EdgeLook look{.object = hit.object,
                .inverse_distance = 1 / hit.distance,
                .color = object.color_at(hit.triangle, first, hit.u, hit.v)};
  const auto corner = [&](int c) -> const TracedObject::Vertex& {
    return object.vertices[object.triangles[hit.triangle].index[c]];
  };
  if (object.has_normals)
    look.normal =
        first * Vector3f(corner(0).normal) + hit.u * Vector3f(corner(1).normal) + hit.v * Vector3f(corner(2).normal);
  else
    look.normal = (Vector3f(corner(1).position) - Vector3f(corner(0).position))
                      .cross(Vector3f(corner(2).position) - Vector3f(corner(0).position));
  look.normal.stableNormalize();
  return look;
}

bool differ(const EdgeLook& a, const EdgeLook& b) {
  if (a.object != b.object) return true;
  if (a.object == Hit::nothing) return false;
  return (a.color - b.color).squaredNorm() > color_tolerance2 || std::abs(a.normal.dot(b.normal)) < least_cosine;
}

// whether a surface breaks off between three pixels in a row, as an arm before a body of the same object does
bool breaks(const EdgeLook& before, const EdgeLook& here, const EdgeLook& after) {
  if (here.object == Hit::nothing || before.object != here.object || after.object != here.object) return false;
  const float bend = before.inverse_distance - 2 * here.inverse_distance + after.inverse_distance;
  return std::abs(bend) > bend_tolerance * here.inverse_distance;
}

bool is_edge(const std::vector<EdgeLook>& looks, int width, int height, int x, int y) {
  const EdgeLook* here = &looks[std::size_t(y) * width + x];
  for (int row = std::max(y - 1, 0); row <= std::min(y + 1, height - 1); ++row)
    for (int column = std::max(x - 1, 0); column <= std::min(x + 1, width - 1); ++column)
      if (differ(*here, looks[std::size_t(row) * width + column])) return true;
  return (x > 0 && x + 1 < width && breaks(here[-1], *here, here[1])) ||
         (y > 0 && y + 1 < height && breaks(here[-width], *here, here[width]));
}

}  // namespace

std::vector<Hit> find_first_hits(const RayScene& rays, const RenderScene& scene, const FirstHitOptions& options) {
  const int step = options.step, first = step / 2;
  const int columns = (options.width - first + step - 1) / step, lines = (options.height - first + step - 1) / step;
  std::vector<Hit> hits(std::size_t(columns) * lines);
  CameraView pinhole = view_at(scene, options.time, options.width, options.height);
  pinhole.aperture_radius = 0;
  parallel_blocks(lines, 8, [&](Eigen::Index begin, Eigen::Index end) {
    rows::RayRows bundle;
    rows::HitRows found;
    for (int line = int(begin); line < int(end); ++line)
      for (int left = 0; left < columns; left += rows::capacity) {
        const int count = std::min(rows::capacity, columns - left);
        for (int i = 0; i < count; ++i) {
          const int x = first + step * (left + i), y = first + step * line;
          Ray ray = camera_ray(pinhole, float(x) + 0.5f, float(y) + 0.5f, {0, 0});
          ray.time = options.time;
          bundle.set(i, ray);
        }
        rays.intersect(bundle, count, true, found);
        for (int i = 0; i < count; ++i)
          if (found.found(i)) hits[std::size_t(line) * columns + left + i] = found.at(i);
      }
  });
  return hits;
}

std::vector<Hit> find_first_hits(const RayScene& rays, const RenderScene& scene, int width, int height) {
  return find_first_hits(rays, scene, {.width = width, .height = height, .time = scene.moment});
}

bool differ(const RayScene& rays, const Hit& a, const Hit& b) {
  return differ(look_of(rays.objects(), a), look_of(rays.objects(), b));
}

std::vector<char> find_edges(const RayScene& rays, const std::vector<Hit>& hits, int width, int height) {
  std::vector<EdgeLook> looks(hits.size());
  std::vector<char> edges(hits.size(), 0);
  parallel_blocks(Eigen::Index(hits.size()), 8192, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) looks[std::size_t(i)] = look_of(rays.objects(), hits[std::size_t(i)]);
  });
  parallel_blocks(height, 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < width; ++x) edges[std::size_t(y) * width + x] = is_edge(looks, width, height, x, y);
  });
  return edges;
}

}  // namespace umax
