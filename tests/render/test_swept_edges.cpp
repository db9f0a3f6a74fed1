// The pixels that edges sweep over while the shutter is open.
#include <tbb/global_control.h>

#include <cmath>

#include "render/trace/clip_frame.h"
#include "render/trace/path_trace.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 96, height = 64;

RenderScene ball_before_floor() {
  RenderScene scene = sphere_on_floor();
  scene.camera.position = {0, 2, 6};
  scene.moment = 0.5f;
  return scene;
}

/// A ball that goes through these places while the shutter is open; at the middle one at the scene's moment.
void fly(RenderScene& scene, double radius, std::initializer_list<Vector3d> places) {
  std::vector<std::shared_ptr<const TriangleMesh>>& instants = scene.objects[0].motion.instants;
  for (const Vector3d& place : places)
    instants.push_back(std::make_shared<const TriangleMesh>(moved(unit_sphere(4), place, radius)));
  scene.objects[0].mesh = instants[instants.size() / 2];
}

struct Found {
  int changed = 0, missed = 0, marked = 0;  // pixels that show one object, then another; of them not marked; marked
};

Found look(const RenderScene& scene) {
  const RayScene rays(scene);
  const std::vector<Hit> now = find_first_hits(rays, scene, width, height);
  const std::vector<char> swept = find_swept_edges(rays, scene, now, width, height);
  constexpr int times = 32;
  std::vector<char> changes(now.size(), 0);
  for (int k = 0; k <= times; ++k) {
    const std::vector<Hit> then =
        find_first_hits(rays, scene, {.width = width, .height = height, .time = float(k) / times});
    for (std::size_t i = 0; i < now.size(); ++i) changes[i] |= char(then[i].object != now[i].object);
  }
  Found found;
  for (std::size_t i = 0; i < now.size(); ++i) {
    found.changed += changes[i];
    found.missed += changes[i] && !swept[i];
    found.marked += swept[i] != 0;
  }
  return found;
}

}  // namespace

TEST_CASE("pixels that an object comes over or leaves while the shutter is open are edges") {
  RenderScene scene = ball_before_floor();
  SECTION("a ball that flies past") {
    fly(scene, 0.6, {{-0.6, 1.2, 0}, {0, 1.2, 0}, {0.6, 1.2, 0}});
  }
  SECTION("a small one, on a bent way, that any pixel shows for a short time only") {
    fly(scene, 0.12, {{-1.5, 0.4, 0}, {-0.8, 1.6, 0}, {0, 2, 0}, {0.8, 1.6, 0}, {1.5, 0.4, 0}});
  }
  SECTION("from the moment on at which the shutter opens") {
    fly(scene, 0.3, {{-1, 1, 0}, {0.5, 1.5, 0}});
    scene.objects[0].mesh = scene.objects[0].motion.instants[0];
    scene.moment = 0;
  }
  SECTION("the camera moves") {
    for (const float x : {-0.4f, 0.0f, 0.4f}) {
      Camera camera = scene.camera;
      camera.position.x() = x;
      scene.camera_path.push_back(camera);
    }
  }
  const Found found = look(scene);
  CAPTURE(found.changed, found.missed, found.marked);
  CHECK(found.changed > 40);
  CHECK(found.missed == 0);
  CHECK(found.marked < found.changed + width * height / 8);
}

TEST_CASE("what comes into the picture, or out from behind something, has edges where it then is") {
  RenderScene scene = ball_before_floor();
  SECTION("from above the picture") {
    fly(scene, 0.5, {{0, 5.2, 0}, {0, 4, 0}, {0, 2.4, 0}});
  }
  SECTION("from behind a wall") {
    fly(scene, 0.5, {{-1.6, 1, -2}, {-1.5, 1, -2}, {1, 1, -2}});
    TriangleMesh wall = floor_square(2);
    wall.positions.col(1) = -wall.positions.col(2);
    wall.positions.col(2).setZero();
    scene.objects.push_back(render_object(moved(wall, {-2, 0, -0.5})));
  }
  const Found found = look(scene);
  CAPTURE(found.changed, found.missed, found.marked);
  CHECK(found.changed > 150);
  CHECK(found.missed < found.changed / 10);
}

TEST_CASE("where nothing moves, edges are those of the one instant, the same for one thread and two") {
  RenderScene scene = ball_before_floor();
  const auto swept = [&] {
    const RayScene rays(scene);
    return find_swept_edges(rays, scene, find_first_hits(rays, scene, width, height), width, height);
  };
  const RayScene rays(scene);
  CHECK(swept() == find_edges(rays, find_first_hits(rays, scene, width, height), width, height));
  fly(scene, 0.6, {{-0.6, 1.2, 0}, {0, 1.2, 0}, {0.6, 1.2, 0}});
  std::vector<char> one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = swept();
  }
  CHECK(one == swept());
}

TEST_CASE("what something passes before is gathered from no other frame, what passes is") {
  RenderScene scene = ball_before_floor();
  fly(scene, 0.6, {{-0.6, 1.2, 0}, {0, 1.2, 0}, {0.6, 1.2, 0}});
  const RayScene rays(scene);
  const std::vector<Hit> hits = find_first_hits(rays, scene, width, height);
  const std::vector<char> edges = find_swept_edges(rays, scene, hits, width, height);
  const TracedImage image = path_trace(rays, scene, {.width = width, .height = height, .samples = 1, .bounces = 0});
  const ClipFrame frame = make_clip_frame(hits, scene, image, edges);
  int apart = 0, wrong = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const bool is_apart = std::isnan(frame.points[i].distance);
    apart += is_apart;
    wrong += is_apart != (edges[i] == 2 && hits[i].object != 0);
  }
  CHECK(apart > 100);
  CHECK(wrong == 0);
}
