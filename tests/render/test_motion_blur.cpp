#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "render/annotation/annotate.h"
#include "render/image/flip.h"
#include "render/scene/sampling.h"
#include "render/trace/path_trace.h"
#include "tests/support/catch.h"
#include "tests/support/golden.h"
#include "tests/support/picture_part.h"
#include "tests/support/render_shapes.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 48, height = 32;
constexpr double radius = 7, travel = 22;  // [px]

// a black ball before white, so far away that a unit of length is a pixel
RenderScene black_ball() {
  RenderScene scene;
  constexpr float distance = 4000;
  scene.objects.push_back(render_object(moved(unit_sphere(5), {0, 0, 0}, radius), {.base_color = {0, 0, 0}, .ior = 1}));
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.backdrop = Vector3f(1, 1, 1);
  scene.camera = {.position = {0, 0, distance}, .target = {0, 0, 0}};
  scene.camera.vertical_fov_degrees = 2 * std::atan(0.5f * height / distance) * 180 / std::numbers::pi_v<float>;
  return scene;
}

std::shared_ptr<const TriangleMesh> ball_at(double x) {
  return std::make_shared<const TriangleMesh>(moved(unit_sphere(5), {x, 0, 0}, radius));
}

// share of the time that a disc whose middle goes straight from x0 to x1 covers a point
double time_covered(double x, double y, double x0, double x1) {
  const double chord = std::sqrt(std::max(0.0, radius * radius - y * y));
  const double overlap = std::min(x + chord, x1) - std::max(x - chord, x0);
  return std::max(0.0, overlap) / (x1 - x0);
}

// of a pixel, through its filter
double expected_light(int column, int row, double x0, double x1) {
  const PixelFilter& filter = pixel_filter();
  constexpr int steps = 48;
  double covered = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps; ++j) {
      const Vector2f offset = filter.offset({(float(i) + 0.5f) / steps, (float(j) + 0.5f) / steps});
      covered += time_covered(column + 0.5 + double(offset.x()) - 0.5 * width,
                              row + 0.5 + double(offset.y()) - 0.5 * height, x0, x1);
    }
  }
  return 1 - covered / (steps * steps);
}

void check_coverage(const RenderScene& scene, double x0, double x1) {
  const TracedImage image = path_trace(scene, {.width = width, .height = height, .samples = 4096, .bounces = 0});
  double mean = 0, largest = 0;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double difference =
          std::abs(double(image.color.pixel(column, row)[1]) - expected_light(column, row, x0, x1));
      mean += difference / (width * height);
      largest = std::max(largest, difference);
    }
  }
  CHECK(mean < 0.001);
  CHECK(largest < 0.012);
}

// a bar that turns in its place before a plain wall, lit from the side
RenderScene bar_at(double angle) {
  RenderScene scene;
  TriangleMesh bar = make_block({0, 0, 0}, {2.4, 0.3, 0.3});
  bar.positions *= Eigen::AngleAxisd(angle, Vector3d(0.2, 0.3, 1).normalized()).toRotationMatrix().transpose();
  scene.objects.push_back(make_object("bar", bar, {.base_color = {0.8f, 0.25f, 0.1f}, .roughness = 0.5f}));
  scene.objects.push_back(make_object("wall", make_block({0, 0, -1.5}, {9, 9, 0.2}), {.roughness = 0.9f}));
  scene.lights.push_back({.corner = {2, 2, 3}, .edge_u = {0, 1, 0}, .edge_v = {1, 0, 0}, .radiance = {40, 40, 40}});
  scene.sky = ConstantSky{{0.3f, 0.35f, 0.4f}};
  scene.camera = {.position = {0, 0, 5}, .target = {0, 0, 0}};
  return scene;
}

RenderScene turning_bar(double from, double to) {
  constexpr int segments = 12;
  RenderScene scene = bar_at(0.5 * (from + to));
  for (int k = 0; k <= segments; ++k)
    scene.objects[0].motion.instants.push_back(bar_at(from + (to - from) * k / segments).objects[0].mesh);
  return scene;
}

}  // namespace

TEST_CASE("a ball that moves covers every pixel for the share of time that geometry says") {
  RenderScene scene = black_ball();
  SurfaceMotion& motion = scene.objects[0].motion;
  SECTION("two instants, as the shutter opens and closes") {
    motion.instants = {ball_at(-travel / 2), ball_at(travel / 2)};
    check_coverage(scene, -travel / 2, travel / 2);
  }
  SECTION("instants before and after the shutter") {
    motion.first = -1;
    motion.last = 2;
    motion.instants = {ball_at(-1.5 * travel), ball_at(-travel / 2), ball_at(travel / 2), ball_at(1.5 * travel)};
    check_coverage(scene, -travel / 2, travel / 2);
  }
  SECTION("the shutter is open while it goes from one segment into the next") {
    motion.first = -0.5;
    motion.last = 1.5;
    motion.instants = {ball_at(-travel), ball_at(0), ball_at(travel)};
    check_coverage(scene, -travel / 2, travel / 2);
  }
  SECTION("the camera moves in its place") {
    for (const float x : {-1.0f, 0.0f, 1.0f}) {
      Camera camera = scene.camera;
      camera.position.x() = camera.target.x() = x * float(travel) / 2;
      scene.camera_path.push_back(camera);
    }
    check_coverage(scene, -travel / 2, travel / 2);
  }
}

TEST_CASE("a bar that turns looks like the mean of 256 stills") {
  const double from = -0.4, to = 0.6;  // [rad]
  PathTraceOptions options{.width = 96, .height = 64, .samples = 1024};
  const RenderScene moving = turning_bar(from, to);
  const Image blurred = path_trace(moving, options).color;
  Image mean(options.width, options.height);
  options.samples = 4;
  for (int k = 0; k < 256; ++k) {
    options.seed = unsigned(k) + 2;
    const Image still = path_trace(bar_at(from + (to - from) * (k + 0.5) / 256), options).color;
    for (std::size_t i = 0; i < mean.values.size(); ++i) mean.values[i] += still.values[i] / 256;
  }
  const FlipResult difference = flip(present(mean, moving), present(blurred, moving));
  INFO("mean FLIP " << difference.mean);
  CHECK(difference.mean <= 0.01);
  const Image sharp = path_trace(bar_at(0.5 * (from + to)), {.width = 96, .height = 64, .samples = 64}).color;
  CHECK(flip(present(mean, moving), present(sharp, moving)).mean > 0.03);
}

TEST_CASE("a surface that moves nowhere looks as one that stands still") {
  RenderScene scene = sphere_on_floor();
  const PathTraceOptions options{.width = 60, .height = 40, .samples = 64};
  const Image8 still = present(path_trace(scene, options).color, scene);
  scene.objects[0].motion.instants = {scene.objects[0].mesh, scene.objects[0].mesh, scene.objects[0].mesh};
  CHECK(flip(still, present(path_trace(scene, options).color, scene)).mean < 0.004);
}

TEST_CASE("blurred pictures are bit-identical for one thread and two, and for any part of them") {
  const RenderScene scene = turning_bar(0, 0.5);
  PathTraceOptions options{.width = 60, .height = 40, .samples = 4};
  TracedImage one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = path_trace(scene, options);
  }
  CHECK(one.color.values == path_trace(scene, options).color.values);
  options.crop = Crop{.x0 = 17, .y0 = 5, .x1 = 44, .y1 = 33};
  const TracedImage part = path_trace(scene, options);
  CHECK(is_part_of(one.color, *options.crop, part.color));
}

TEST_CASE("motion of another mesh is refused by name") {
  RenderScene scene = sphere_on_floor();
  scene.objects[0].motion.instants = {scene.objects[0].mesh, scene.objects[1].mesh};
  CHECK_THROWS_AS(path_trace(scene, {.width = 8, .height = 8, .samples = 1}), Error);
}

TEST_CASE("a blurred picture looks like its reference") {
  RenderScene scene = make_still_life();
  const auto shifted = [](const TriangleMesh& mesh, const Vector3d& by) {
    TriangleMesh other = mesh;
    other.positions.rowwise() += by.transpose();
    return std::make_shared<const TriangleMesh>(other);
  };
  for (std::size_t i = 1; i < scene.objects.size(); i += 2) {
    const TriangleMesh& mesh = *scene.objects[i].mesh;
    scene.objects[i].motion.instants = {shifted(mesh, {-0.25, 0, 0}), shifted(mesh, {0, 0.1, 0}),
                                        shifted(mesh, {0.25, 0, 0})};
  }
  const GoldenTolerance tolerance{.fail = 4, .percent = 3, .hard_fail = 96, .mean_flip = 0.02};
  check_golden("traced_motion_blur", path_trace(scene, {.width = 128, .height = 72, .samples = 64}).color, scene,
               tolerance);
}
