#include "render/trace/path_trace.h"

#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "tests/support/catch.h"
#include "tests/support/picture_part.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

Eigen::Vector3d mean_of(const Image& image) {
  Eigen::Vector3d sum(0, 0, 0);
  for (std::size_t i = 0; i < image.values.size(); ++i) sum[i % 3] += double(image.values[i]);
  return sum * 3 / double(image.values.size());
}

RenderScene furnace(const Look& look) {
  RenderScene scene;
  scene.objects.push_back(render_object(unit_sphere(5), look));
  scene.sky = ConstantSky{{1, 1, 1}};
  scene.camera.position = {0, 0, 4};
  scene.camera.target = {0, 0, 0};
  return scene;
}

}  // namespace

TEST_CASE("a white sphere cannot be seen in a white furnace") {
  Look look{.base_color = {1, 1, 1}};
  look.roughness = GENERATE(0.1f, 0.5f, 1.0f);
  look.metallic = GENERATE(0.0f, 1.0f);
  look.clearcoat = GENERATE(0.0f, 1.0f);
  const TracedImage image = path_trace(furnace(look), {.width = 32, .height = 32, .samples = 64});
  CAPTURE(look.roughness, look.metallic, look.clearcoat);
  CHECK(mean_of(image.color).x() == Approx(1).margin(0.005));
  double middle = 0;
  for (int i = 0; i < 64; ++i) middle += double(image.color.pixel(12 + i % 8, 12 + i / 8)[1]) / 64;
  CHECK(middle == Approx(1).margin(0.006));
}

TEST_CASE("every bounce adds its term of the series") {
  // inside a sphere of albedo a, lit from a small rectangle: the light of bounce n + 1 is a times that of bounce n, and
  // the same everywhere from the second bounce on, because a sphere's inside lights itself evenly
  RenderScene scene = furnace({.base_color = {0.5f, 0.5f, 0.5f}, .ior = 1});
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.camera.position = {0, 0, 0.5f};
  scene.lights.push_back(
      {.corner = {-0.05f, 0.9f, -0.05f}, .edge_u = {0.1f, 0, 0}, .edge_v = {0, 0, 0.1f}, .radiance = {100, 100, 100}});
  double previous = 0, term[4];
  for (int bounces = 0; bounces < 4; ++bounces) {
    const TracedImage image = path_trace(scene, {.width = 12, .height = 12, .samples = 256, .bounces = bounces});
    const double sum = mean_of(image.color).x();
    term[bounces] = sum - previous;
    previous = sum;
  }
  // flux pi A L spread over the sphere's area 4 pi, times albedo over pi for each bounce
  const double flux = std::numbers::pi * 0.01 * 100,
               even = 0.5 / std::numbers::pi * 0.5 * flux / (4 * std::numbers::pi);
  CHECK(term[1] == Approx(even).epsilon(0.02));
  CHECK(term[2] == Approx(even / 2).epsilon(0.02));
  CHECK(term[3] == Approx(even / 4).epsilon(0.03));
}

TEST_CASE("a floor under a rectangle has the radiance of the form factor") {
  RenderScene scene;
  scene.objects.push_back(render_object(floor_square(30), {.base_color = {0.6f, 0.4f, 0.2f}, .ior = 1}));
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.lights.push_back({.corner = {-1, 2, -1}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 2}, .radiance = {5, 5, 5}});
  scene.camera = {.position = {0, 1, 3}, .target = {0, 0, 0}, .vertical_fov_degrees = 0.1f};
  const int bounces = GENERATE(0, 4);
  const TracedImage image = path_trace(scene, {.width = 8, .height = 8, .samples = 64, .bounces = bounces});
  const double a = 0.5, r = std::sqrt(1 + a * a);
  const double factor = 4 * 2 * a / r * std::atan(a / r) / (2 * std::numbers::pi);
  CHECK(mean_of(image.color).x() == Approx(0.6 * 5 * factor).epsilon(0.005));
  CHECK(mean_of(image.color).z() == Approx(0.2 * 5 * factor).epsilon(0.005));
  CHECK(double(*image.depth.pixel(4, 4)) == Approx(std::sqrt(10.0)).epsilon(1e-3));
  CHECK(double(image.normal.pixel(4, 4)[1]) == Approx(1));
}

TEST_CASE("a glossy floor mirrors a light as bright as it is, found by either strategy") {
  // a nearly smooth metal: only the surface's own directions find the light; a rough one: only aiming does well
  RenderScene scene;
  Look metal{.base_color = {1, 1, 1}, .metallic = 1};
  metal.roughness = GENERATE(0.02f, 0.2f);
  scene.objects.push_back(render_object(floor_square(30), metal));
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.lights.push_back({.corner = {-8, 2, -12}, .edge_u = {16, 0, 0}, .edge_v = {0, 0, 16}, .radiance = {3, 3, 3}});
  scene.camera = {.position = {0, 1.5f, 1}, .target = {0, 0, 0}, .vertical_fov_degrees = 0.1f};
  const TracedImage image = path_trace(scene, {.width = 8, .height = 8, .samples = 64});
  CHECK(mean_of(image.color).x() == Approx(3).epsilon(0.01));
}

TEST_CASE("sun and picture of the sky light a floor with their irradiance") {
  RenderScene scene;
  scene.objects.push_back(render_object(floor_square(300), {.base_color = {0.5f, 0.5f, 0.5f}, .ior = 1}));
  scene.camera = {.position = {0, 2, 2}, .target = {0, 0, 0}, .vertical_fov_degrees = 1};
  auto white = std::make_shared<Image>(32, 16);
  for (float& v : white->values) v = 0.8f;
  const PathTraceOptions options{.width = 8, .height = 8, .samples = 64};
  scene.sky = EnvironmentMap{.image = white};
  CHECK(mean_of(path_trace(scene, options).color).x() == Approx(0.4).epsilon(0.01));
  // a sun of 0.5 and of 8 degrees
  scene.sky = DaylightSky{.sun_direction = {0, 1, 0}};
  const double small = mean_of(path_trace(scene, options).color).y();
  scene.sky = DaylightSky{.sun_direction = {0, 1, 0}, .sun_size_degrees = 8};
  CHECK(mean_of(path_trace(scene, options).color).y() == Approx(small).epsilon(0.02));
  CHECK(small > 0.3);
}

TEST_CASE("pictures are bit-identical for one thread and two, and for any part of them") {
  const RenderScene scene = sphere_on_floor();
  PathTraceOptions options{.width = 60, .height = 40, .samples = 4};
  TracedImage one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = path_trace(scene, options);
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
  const TracedImage two = path_trace(scene, options);
  CHECK(one.color.values == two.color.values);
  CHECK(one.variance.values == two.variance.values);
  CHECK(one.half.values == two.half.values);
  CHECK(one.normal.values == two.normal.values);
  options.crop = Crop{.x0 = 17, .y0 = 5, .x1 = 44, .y1 = 33};
  const TracedImage part = path_trace(scene, options);
  CHECK(is_part_of(one.color, *options.crop, part.color));
}

TEST_CASE("the setting for tiny numbers does not leak out of the tracer") {
  path_trace(sphere_on_floor(), {.width = 32, .height = 32, .samples = 1});
  volatile float tiny = 1e-39f;
  volatile float half = tiny * 0.5f;
  CHECK(half > 0);
}

TEST_CASE("another seed gives other noise about the same picture") {
  const RenderScene scene = sphere_on_floor();
  const TracedImage a = path_trace(scene, {.width = 32, .height = 24, .samples = 64, .seed = 1});
  const TracedImage b = path_trace(scene, {.width = 32, .height = 24, .samples = 64, .seed = 2});
  CHECK(a.color.values != b.color.values);
  CHECK(mean_of(a.color).x() == Approx(mean_of(b.color).x()).epsilon(0.01));
}

TEST_CASE("what blocks the light casts a shadow") {
  RenderScene scene;
  scene.objects.push_back(render_object(floor_square(30), {.ior = 1}));
  scene.objects.push_back(render_object(floor_square(3, 1)));
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.lights.push_back(
      {.corner = {-0.1f, 5, -0.1f}, .edge_u = {0.2f, 0, 0}, .edge_v = {0, 0, 0.2f}, .radiance = {9, 9, 9}});
  scene.camera = {.position = {0, 0.5f, 0.5f}, .target = {0, 0, 0}, .vertical_fov_degrees = 5};
  CHECK(mean_of(path_trace(scene, {.width = 8, .height = 8, .samples = 16, .bounces = 0}).color).x() == 0);
  scene.camera = {.position = {7, 0.5f, 0.5f}, .target = {7, 0, 0}, .vertical_fov_degrees = 5};
  CHECK(mean_of(path_trace(scene, {.width = 8, .height = 8, .samples = 16, .bounces = 0}).color).x() > 0);
}

TEST_CASE("the camera sees the backdrop and visible lights") {
  RenderScene scene;
  scene.backdrop = Vector3f(0.1f, 0.2f, 0.3f);
  const PathTraceOptions options{.width = 4, .height = 4, .samples = 4};
  CHECK(mean_of(path_trace(scene, options).color).z() == Approx(0.3));
  // in front of the camera, facing it: u x v = +z
  scene.lights.push_back(
      {.corner = {-9, -9, 0}, .edge_u = {18, 0, 0}, .edge_v = {0, 18, 0}, .radiance = {7, 7, 7}, .visible = true});
  CHECK(mean_of(path_trace(scene, options).color).z() == Approx(7));
  scene.lights[0].visible = false;
  CHECK(mean_of(path_trace(scene, options).color).z() == Approx(0.3));
}

TEST_CASE("progress runs to 1 and a stopped picture stays black from there") {
  const RenderScene scene = sphere_on_floor();
  PathTraceOptions options{.width = 64, .height = 64, .samples = 1};
  std::vector<double> fractions;
  options.on_progress = [&](double fraction) { fractions.push_back(fraction); };
  path_trace(scene, options);
  REQUIRE(fractions.size() == 16);
  CHECK(std::is_sorted(fractions.begin(), fractions.end()));
  CHECK(fractions.back() == 1);
  const std::atomic<bool> stop = true;
  options.stop = &stop;
  CHECK(mean_of(path_trace(scene, options).color).maxCoeff() == 0);
}

TEST_CASE("recorded rays are replayed with the same hits") {
  const RenderScene scene = sphere_on_floor();
  const RayScene rays(scene);
  RayRecording recording;
  PathTraceOptions options{.width = 32, .height = 32, .samples = 2};
  options.recording = &recording;
  path_trace(rays, scene, options);
  const ReplayResult a = rays.replay(recording), b = RayScene(scene).replay(recording);
  CHECK(a.num_rays > 32 * 32 * 2 * 2);
  CHECK(a.num_rays == b.num_rays);
  CHECK(a.checksum == b.checksum);
  recording[0][0].ray.direction *= -1;
  CHECK(rays.replay(recording).checksum != a.checksum);
}

TEST_CASE("options that make no picture are refused") {
  PathTraceOptions options{.width = 8, .height = 8, .samples = 1};
  SECTION("no samples") {
    options.samples = 0;
  }
  SECTION("no width") {
    options.width = 0;
  }
  SECTION("negative bounces") {
    options.bounces = -1;
  }
  SECTION("a crop outside") {
    options.crop = Crop{.x0 = 0, .y0 = 0, .x1 = 9, .y1 = 8};
  }
  SECTION("an empty crop") {
    options.crop = Crop{.x0 = 3, .y0 = 0, .x1 = 3, .y1 = 8};
  }
  CHECK_THROWS_AS(path_trace(RenderScene{}, options), Error);
}
