// Where edges go while the shutter is open. An edge is the rim of the surface that lies before the others, and goes with
// it: what few rays have met tells all places on its way, however fast it is.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "core/base/parallel.h"
#include "render/scene/camera.h"
#include "render/trace/first_hits.h"

namespace umax {
namespace {

constexpr int num_segments = 16;  // of a way, each taken for straight

bool moves(const RenderObject& object) {
  return object.motion.instants.size() > 1;
}

float time_of(int end) {
  return float(end) / num_segments;
}

class Sweeper {
 public:
  Sweeper(const RayScene& rays, const RenderScene& scene, int width, int height, std::vector<char>& swept)
      : rays_(rays),
        scene_(scene),
        width_(width),
        height_(height),
        camera_moves_(scene.camera_path.size() > 1),
        camera_(view_at_moment(scene, width, height)),
        swept_(swept) {
    for (int k = 0; k <= num_segments; ++k) cameras_.emplace_back(view_at(scene, time_of(k), width, height));
  }

  /// What the edges of the scene's moment sweep over.
  void sweep(const std::vector<Hit>& hits) {
    const std::vector<char> edges = swept_;
    parallel_blocks(height_, 8, [&](Eigen::Index begin, Eigen::Index end) {
      for (int y = int(begin); y < int(end); ++y)
        for (int x = 0; x < width_; ++x)
          if (edges[std::size_t(y) * width_ + x]) sweep_pixel(hits, x, y);
    });
  }

  /// What the time at an end shows though nothing has swept over it comes out from behind something, or into the picture:
  /// all its way.
  void sweep_newcomers(const std::vector<Hit>& hits, float time) {
    constexpr int step = 4;
    const Projection& camera = time > 0 ? cameras_.back() : cameras_.front();
    const std::vector<Hit> others =
        find_first_hits(rays_, scene_, {.width = width_, .height = height_, .time = time, .step = step});
    std::vector<Way> ways;
    std::size_t i = 0;
    for (int y = step / 2; y < height_; y += step)
      for (int x = step / 2; x < width_; x += step, ++i) {
        const std::size_t pixel = std::size_t(y) * width_ + x;
        if (!swept_[pixel] && differ(rays_, hits[pixel], others[i]))
          ways.push_back(way_of(others[i], time, camera, x, y));
      }
    for (const Way& way : ways) mark_way(way, step);
  }

 private:
  using Way = std::array<Vector2f, num_segments + 1>;  // [px] ends of its segments

  void sweep_pixel(const std::vector<Hit>& hits, int x, int y) {
    const Hit front = nearest_around(hits, x, y);
    const Way way = way_of(front, scene_.moment, camera_, x, y);
    mark_way(way, 1);
    // the rim's way is known to a pixel, and so is how far it goes
    const bool is_outside = hits[std::size_t(y) * width_ + x].object != front.object;
    if (is_outside && way.front() != way.back())
      for (const Vector2f& end : {way.front(), way.back()}) mark_block(end, 3);
  }

  // of the point that a pixel shows at a time; the pixel where it stands still, or is behind the camera for a while
  Way way_of(const Hit& hit, float time, const Projection& camera, int x, int y) const {
    Way still, way;
    still.fill({float(x), float(y)});
    if (!hit.found() || !(camera_moves_ || moves(scene_.objects[hit.object]))) return still;
    const TracedObject& object = rays_.objects()[hit.object];
    const Vector2f here = camera.place(object.position_on(hit, time));
    for (int k = 0; k <= num_segments; ++k) {
      const Vector3f point = object.position_on(hit, time_of(k));
      if (!(cameras_[k].depth(point) > 0)) return still;
      const Vector2f there = cameras_[k].place(point) - here;
      way[k] = {float(x) + there.x(), float(y) - there.y()};
    }
    return way;
  }

  Hit nearest_around(const std::vector<Hit>& hits, int x, int y) const {
    Hit nearest;
    for (int row = std::max(y - 1, 0); row <= std::min(y + 1, height_ - 1); ++row)
      for (int column = std::max(x - 1, 0); column <= std::min(x + 1, width_ - 1); ++column) {
        const Hit& hit = hits[std::size_t(row) * width_ + column];
        if (hit.found() && (!nearest.found() || hit.distance < nearest.distance)) nearest = hit;
      }
    return nearest;
  }

  // as wide as `size`; of what stands still, nothing
  void mark_way(const Way& way, int size) {
    for (int k = 0; k < num_segments; ++k)
      if (way[k] != way[k + 1]) mark_between(way[k], way[k + 1], size);
  }

  // the part of a segment that lies in the picture
  void mark_between(const Vector2f& from, const Vector2f& to, int size) {
    const Vector2f way = to - from, most(float(width_ - 1), float(height_ - 1));
    float begin = 0, end = 1;
    for (int c = 0; c < 2; ++c) {
      if (way[c] == 0) continue;
      const float a = -from[c] / way[c], b = (most[c] - from[c]) / way[c];
      begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
    }
    const int steps = int(std::ceil((end - begin) * way.cwiseAbs().maxCoeff()));
    for (int i = 0; i <= steps; ++i)
      mark_block(from + (begin + (end - begin) * float(i) / float(std::max(steps, 1))) * way, size);
  }

  // around a place
  void mark_block(const Vector2f& place, int size) {
    const int left = int(std::lround(place.x())) - size / 2, top = int(std::lround(place.y())) - size / 2;
    for (int row = std::max(top, 0); row < std::min(top + size, height_); ++row)
      for (int column = std::max(left, 0); column < std::min(left + size, width_); ++column) mark(column, row);
  }

  // from several threads at once, which all write the same
  void mark(int x, int y) {
    std::atomic_ref<char>(swept_[std::size_t(y) * width_ + x]).store(swept_edge, std::memory_order_relaxed);
  }

  const RayScene& rays_;
  const RenderScene& scene_;
  int width_, height_;
  bool camera_moves_;
  Projection camera_;
  std::vector<Projection> cameras_;  // at the ends of segments
  std::vector<char>& swept_;
};

}  // namespace

std::vector<char> find_swept_edges(const RayScene& rays, const RenderScene& scene, const std::vector<Hit>& hits,
                                   int width, int height) {
  std::vector<char> swept = find_edges(rays, hits, width, height);
  if (scene.camera_path.size() < 2 && std::none_of(scene.objects.begin(), scene.objects.end(), moves)) return swept;
  Sweeper sweeper(rays, scene, width, height, swept);
  sweeper.sweep(hits);
  // what is hidden at the scene's moment, or out of the picture, is seen as it comes or goes
  for (const float time : {0.0f, 1.0f})
    if (time != scene.moment) sweeper.sweep_newcomers(hits, time);
  return swept;
}

}  // namespace umax
