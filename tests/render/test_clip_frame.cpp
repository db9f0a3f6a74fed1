// Light gathered over the frames of a clip: from the same points alone, and under the same light alone.
#include "render/trace/clip_frame.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "render/trace/denoise.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 96, height = 64, window_size = 5, middle = 2;

/// A frame of a clip whose samples are a part of one sequence, as the program draws them.
ClipFrame trace_frame(const RenderScene& scene, int block, int samples = 8) {
  const RayScene rays(scene);
  return make_clip_frame(
      find_first_hits(rays, scene, width, height), scene,
      path_trace(rays, scene,
                 {.width = width, .height = height, .samples = samples, .block = block, .blocks = window_size}));
}

/// Scenes of five frames, from the place k = -2 ... 2 of each.
template <class SceneAt>
std::vector<ClipFrame> trace_clip(const SceneAt& scene_at, int samples = 8) {
  std::vector<ClipFrame> frames;
  for (int k = 0; k < window_size; ++k) frames.push_back(trace_frame(scene_at(k - middle), k, samples));
  return frames;
}

NoisyLight gather(const std::vector<ClipFrame>& frames, std::size_t centre = middle) {
  std::vector<const ClipFrame*> window;
  for (const ClipFrame& frame : frames) window.push_back(&frame);
  return gather_light(window, centre);
}

RenderScene still_scene() {
  RenderScene scene = sphere_on_floor();
  scene.camera.position = {0, 2, 6};
  return scene;
}

/// Of one frame alone.
NoisyLight light_of(const ClipFrame& frame) {
  return gather_light({&frame}, 0);
}

NoisyLight converged(const RenderScene& scene) {
  return noisy_light(path_trace(scene, {.width = width, .height = height, .samples = 2048, .seed = 99}));
}

/// Mean square of the difference of light, over the pixels that `counts` accepts.
template <class Counts>
double squared_error(const NoisyLight& a, const NoisyLight& b, const Counts& counts) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!counts(x, y)) continue;
      const std::size_t i = std::size_t(y) * width + x;
      for (int c = 0; c < 3; ++c) sum += std::pow(double(a.light[c][i]) - double(b.light[c][i]), 2);
      ++count;
    }
  REQUIRE(count > 0);
  return sum / count;
}

bool everywhere(int, int) {
  return true;
}

}  // namespace

TEST_CASE("a point of a surface is found where another frame shows it, to a hundredth of a pixel") {
  const auto scene_at = [](double shift, const Vector3f& camera) {
    RenderScene scene = still_scene();
    scene.objects[0] = render_object(moved(unit_sphere(4), {shift, 1 + 0.5 * shift, 0.3 * shift}));
    scene.camera.position = camera;
    return scene;
  };
  const ClipFrame here = trace_frame(scene_at(0, {0, 2, 6}), 0, 1),
                  there = trace_frame(scene_at(0.4, {0.7f, 2.2f, 5}), 0, 1);
  const Reprojection reprojection(here, there);
  const CameraView now = here.projection.view;
  int on_ball = 0, on_floor = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const SeenPoint& hit = here.point(x, y);
      if (hit.object == Hit::nothing) continue;
      const Ray ray = camera_ray(now, float(x) + 0.5f, float(y) + 0.5f, {0, 0});
      Vector3f point = ray.origin + hit.distance * ray.direction;
      if (hit.object == 0) point += Vector3f(0.4f, 0.2f, 0.12f);
      (hit.object == 0 ? on_ball : on_floor)++;
      // which ray of the other camera goes there: corner + x step_x + y step_y
      const CameraView& then = there.projection.view;
      const Vector3f towards = point - then.position;
      const Vector3f at_one = towards / towards.dot(then.forward) - then.corner;
      const Reprojection::Place place = reprojection.place(x, y);
      REQUIRE(place.has_place);
      CHECK(std::abs(place.x - at_one.dot(then.step_x) / then.step_x.squaredNorm()) < 0.01f);
      CHECK(std::abs(place.y - at_one.dot(then.step_y) / then.step_y.squaredNorm()) < 0.01f);
      CHECK(place.distance == Approx(double(towards.norm())).epsilon(1e-4));
    }
  CHECK(on_ball > 300);
  CHECK(on_floor > 300);
  CHECK_FALSE(reprojection.stands_still(1));
  // what stays where it is, is found in its own pixel, to the bit
  const Reprojection same(here, here);
  CHECK(same.stands_still(0));
  CHECK(same.place(40, 30).x == 40.5f);
  CHECK(same.place(40, 30).y == 30.5f);
}

TEST_CASE("where nothing moves, five frames have a fifth of the variance of one, and less") {
  const std::vector<ClipFrame> frames = trace_clip([](int) { return still_scene(); });
  const NoisyLight reference = converged(still_scene());
  const double alone = squared_error(light_of(frames[middle]), reference, everywhere),
               gathered = squared_error(gather(frames), reference, everywhere);
  CAPTURE(alone, gathered);
  CHECK(gathered < alone / 4);
  // at the clip's ends from those that are there
  CHECK(squared_error(gather({frames[0], frames[1], frames[2]}, 0), reference, everywhere) < alone / 2.2);
}

TEST_CASE("the two halves of gathered light stay independent: their difference tells the noise") {
  // light of 1 with noise that is drawn anew for each half of each pixel of each frame
  std::vector<ClipFrame> frames = trace_clip([](int) { return still_scene(); }, 16);
  std::mt19937 random(5);
  const auto draw = [&] { return 0.6f + 0.8f * float(random()) / float(std::mt19937::max()); };
  for (ClipFrame& frame : frames)
    for (SeenPoint& point : frame.points) {
      const float first = draw(), second = draw();
      for (int c = 0; c < 3; ++c) point.first[c] = first, point.second[c] = second;
      point.variance = 0.8f * 0.8f / 12 / 2;
    }
  const NoisyLight light = gather(frames);
  double difference = 0, error = 0, product = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double first = double(light.half[1][i]) - 1, second = 2 * (double(light.light[1][i]) - 1) - first;
    difference += (first - second) * (first - second) / 4;
    error += (first + second) * (first + second) / 4;
    product += first * second;
    CHECK(double(light.of_halves[i]) == Approx((first - second) * (first - second) / 4).margin(1e-6));
  }
  CHECK(error == Approx(difference).epsilon(0.06));
  CHECK(std::abs(product) < 0.06 * error);
  // a fifth of what both halves of one frame have
  const double of_frame = 0.8 * 0.8 / 12 / 2;
  CHECK(error / double(light.size()) == Approx(of_frame / 5).epsilon(0.25));
}

TEST_CASE("a ball that flies past leaves nothing of itself on what it hid") {
  const auto scene_at = [](int k) {
    RenderScene scene = still_scene();
    scene.objects[0] = render_object(moved(unit_sphere(4), {0.5 * k, 2.2, 2}, 0.4), {.base_color = {0.9f, 0.9f, 0.9f}});
    scene.objects[1].look.base_color = {0.8f, 0.8f, 0.8f};
    scene.lights.clear();
    return scene;
  };
  std::vector<ClipFrame> frames = trace_clip(scene_at);
  // whatever another frame shows on the ball is poison for what is not the ball
  for (int k = 0; k < window_size; ++k)
    for (SeenPoint& point : frames[k].points)
      if (k != middle && point.object == 0)
        for (int c = 0; c < 3; ++c) point.first[c] = point.second[c] = 1e4f;
  const NoisyLight light = gather(frames);
  int uncovered = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const bool is_ball = frames[middle].points[i].object == 0;
    const bool was_ball = frames[1].points[i].object == 0;
    uncovered += was_ball && !is_ball;
    if (!is_ball) CHECK(light.light[0][i] < 50);
  }
  CHECK(uncovered > 20);
}

TEST_CASE("a light that changes from frame to frame is not smeared") {
  // as one that is switched on: half the frames are of no use
  const auto lit = [](int k) {
    RenderScene scene = still_scene();
    const float power = k < 0 ? 15.0f : 30.0f;
    scene.lights[0].radiance = {power, power, power};
    return scene;
  };
  const NoisyLight reference = converged(lit(0)), light = gather(trace_clip(lit));
  double bias = 0, sum = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    bias += double(light.light[1][i]) - double(reference.light[1][i]);
    sum += double(reference.light[1][i]);
  }
  CAPTURE(bias / sum);
  CHECK(std::abs(bias / sum) < 0.01);  // without rejection: 0.2
}

TEST_CASE("the edge of a shadow that moves stays where it is") {
  // a narrow light, so that the edge is hard, and a roof that moves over the floor
  const auto scene_at = [](int k) {
    RenderScene scene;
    scene.objects.push_back(render_object(moved(floor_square(0.8), {0.25 * k - 0.8, 1.5, 0}), {}));
    scene.objects.push_back(render_object(floor_square(20), {.roughness = 0.8f}));
    scene.lights.push_back(
        {.corner = {0, 8, 0}, .edge_u = {0.1f, 0, 0}, .edge_v = {0, 0, 0.1f}, .radiance = {4000, 4000, 4000}});
    scene.sky = ConstantSky{{0.1f, 0.1f, 0.1f}};
    scene.camera.position = {0.5f, 4, 4};
    scene.camera.target = {0.5f, 0, 0};
    return scene;
  };
  const std::vector<ClipFrame> frames = trace_clip(scene_at);
  const NoisyLight reference = converged(scene_at(0)), light = gather(frames);
  const auto on_floor = [&](int x, int y) { return frames[middle].point(x, y).object == 1; };
  const double alone = squared_error(light_of(frames[middle]), reference, on_floor),
               gathered = squared_error(light, reference, on_floor);
  CAPTURE(alone, gathered);
  CHECK(gathered < alone);
}

TEST_CASE("gathered light is the same bits for one thread and two") {
  const std::vector<ClipFrame> frames = trace_clip([](int k) {
    RenderScene scene = still_scene();
    scene.objects[0] = render_object(moved(unit_sphere(4), {0.05 * k, 1, 0}));
    return scene;
  });
  NoisyLight one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = gather(frames);
  }
  const NoisyLight two = gather(frames);
  CHECK(one.light == two.light);
  CHECK(one.half == two.half);
  CHECK(one.of_paths == two.of_paths);
}

TEST_CASE("pixels that edges cross get their samples, the others as many as are asked for, in a crop too") {
  const RenderScene scene = still_scene();
  const RayScene rays(scene);
  const std::vector<Hit> hits = find_first_hits(rays, scene, width, height);
  PathTraceOptions options{.width = width, .height = height, .samples = 2, .edge_samples = 12};
  options.edges = find_edges(rays, hits, width, height);
  const TracedImage image = path_trace(rays, scene, options);
  int edges = 0;
  for (int y = 1; y + 1 < height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      const std::size_t i = std::size_t(y) * width + x;
      const bool meets_other = hits[i].object != hits[i - 1].object || hits[i].object != hits[i + width].object;
      if (meets_other) CHECK(options.edges[i] == 1);
      CHECK(*image.samples.pixel(x, y) == (options.edges[i] ? 12 : 2));
      edges += options.edges[i];
    }
  CHECK(edges > 50);
  CHECK(edges < width * height / 8);  // the floor, which is seen flat from afar, has none
  options.crop = Crop{.x0 = 30, .y0 = 20, .x1 = 60, .y1 = 50};
  const TracedImage part = path_trace(rays, scene, options);
  for (int y = 20; y < 50; ++y)
    for (int x = 30; x < 60; ++x)
      for (int c = 0; c < 3; ++c) CHECK(part.color.pixel(x - 30, y - 20)[c] == image.color.pixel(x, y)[c]);
}
