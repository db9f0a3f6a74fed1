// Light in matter: energy, Beer-Lambert, Snell, Fresnel, the reflectance of a half space; the same bits whoever counts.
#include "render/trace/matter.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "render/raster/rasterize.h"
#include "render/trace/clip_frame.h"
#include "render/trace/path_trace.h"
#include "tests/support/catch.h"
#include "tests/support/golden.h"
#include "tests/support/picture_part.h"
#include "tests/support/render_shapes.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

Eigen::Vector3d mean_of(const Image& image) {
  Eigen::Vector3d sum(0, 0, 0);
  for (std::size_t i = 0; i < image.values.size(); ++i) sum[Eigen::Index(i % 3)] += double(image.values[i]);
  return sum * 3 / double(image.values.size());
}

/// What a small square in the middle of the picture shows.
Eigen::Vector3d middle_of(const RenderScene& scene, int samples, int bounces = 4) {
  return mean_of(path_trace(scene, {.width = 64,
                                    .height = 64,
                                    .samples = samples,
                                    .bounces = bounces,
                                    .crop = Crop{.x0 = 24, .y0 = 24, .x1 = 40, .y1 = 40}})
                     .color);
}

RenderScene furnace(const TriangleMesh& mesh, const Look& look) {
  RenderScene scene;
  scene.objects.push_back(render_object(mesh, look));
  scene.sky = ConstantSky{{1, 1, 1}};
  scene.camera.position = {0, 0, 4};
  scene.camera.target = {0, 0, 0};
  return scene;
}

/// Chandrasekhar's H function for isotropic scattering, by its integral equation at Gauss points: the light that a half
/// space sends back of even light from all sides.
double reflectance_of_half_space(double albedo) {
  constexpr int n = 400;
  const double root = std::sqrt(1 - albedo);
  std::vector<double> h(n, 1.0), mu(n);
  for (int i = 0; i < n; ++i) mu[std::size_t(i)] = (i + 0.5) / n;
  for (int round = 0; round < 200; ++round) {
    std::vector<double> next(n);
    for (std::size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) sum += mu[j] * h[j] / (mu[i] + mu[j]) / n;
      next[i] = 1 / (root + albedo / 2 * sum);
    }
    h = next;
  }
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += h[i] * mu[i] / n;
  return 1 - 2 * root * sum;
}

}  // namespace

TEST_CASE("white matter cannot be seen in a white furnace, whatever its shares and roughness") {
  Look look{.base_color = {1, 1, 1}};
  look.roughness = GENERATE(0.0f, 0.3f, 1.0f);
  const std::pair<float, float> shares = GENERATE(std::pair{1.0f, 0.0f}, std::pair{0.0f, 1.0f}, std::pair{0.5f, 0.6f});
  look.transmission = shares.first, look.subsurface = shares.second;
  look.subsurface_radius = {0.3f, 0.2f, 0.1f};
  CAPTURE(look.roughness, look.transmission, look.subsurface);
  const bool is_block = GENERATE(false, true);
  const RenderScene scene = furnace(is_block ? make_block({0, 0, 0}, {1, 1.2, 0.8}) : unit_sphere(5), look);
  // light that bounces between a body's own faces is cut off after the last bounce: give it enough
  const Eigen::Vector3d seen = middle_of(scene, 64, 30);
  for (int c = 0; c < 3; ++c) CHECK(seen[c] == Approx(1).margin(0.01));
}

TEST_CASE("matter gives back less light than it gets by what it absorbs, and never more") {
  Look look{.base_color = {0.9f, 0.5f, 0.2f}, .roughness = 0.2f, .clearcoat = GENERATE(0.0f, 1.0f)};
  look.transmission = GENERATE(0.0f, 0.5f, 1.0f);
  look.subsurface = 1;
  look.transmission_depth = 1;
  look.subsurface_radius = {0.1f, 0.1f, 0.1f};
  const Eigen::Vector3d seen = middle_of(furnace(unit_sphere(4), look), 64, 30);
  CHECK(seen.maxCoeff() < 0.98);
  CHECK(seen.x() > seen.y() + 0.05);
  CHECK(seen.y() > seen.z() + 0.05);
}

TEST_CASE("light through a clear slab loses what Beer and Lambert say, and what both faces throw back") {
  Look look{.base_color = {0.8f, 0.5f, 0.1f}, .roughness = 0};
  look.ior = GENERATE(1.0f, 1.5f, 2.0f);
  look.transmission = 1;
  look.transmission_depth = 0.25f;
  RenderScene scene = furnace(slab(50, 0.5), look);
  scene.sky = GradientSky{.horizon = {2, 2, 2}, .zenith = {2, 2, 2}, .ground = {2, 2, 2}};
  scene.camera.vertical_fov_degrees = 0.5f;
  const Eigen::Vector3d seen = middle_of(scene, 2048);
  const double f = std::pow((double(look.ior) - 1) / (double(look.ior) + 1), 2);
  for (int c = 0; c < 3; ++c) {
    const double inside = std::pow(double(look.base_color[c]), 0.5 / 0.25);
    const double through = (1 - f) * (1 - f) * inside / (1 - f * f * inside * inside);
    const double back = f + (1 - f) * (1 - f) * f * inside * inside / (1 - f * f * inside * inside);
    CHECK(seen[c] == Approx(2 * (through + back)).epsilon(0.01));
  }
}

TEST_CASE("cloudy matter that fills a half space reflects its colour, as Chandrasekhar's H function has it") {
  for (const float color : {0.1f, 0.4f, 0.7f, 0.9f}) {
    CAPTURE(color);
    const double share = double(scattered_share({color, color, color}).x());
    CHECK(reflectance_of_half_space(share) == Approx(double(color)).margin(0.004));
    // the walk itself, on a block that is large against the radius
    Look look{.base_color = {color, color, color}, .roughness = 1, .ior = 1};
    look.subsurface = 1;
    look.subsurface_radius = {0.004f, 0.004f, 0.004f};
    CHECK(middle_of(furnace(make_block({0, 0, 0}, {2, 2, 2}), look), 256, 0).x() ==
          Approx(double(color)).margin(0.006));
  }
}

TEST_CASE("each colour wanders as far as its radius says") {
  // a thin edge of light on a large block: the light that comes out beside it falls with the radius
  Look look{.base_color = {0.9f, 0.9f, 0.9f}, .roughness = 1, .ior = 1};
  look.subsurface = 1;
  look.subsurface_radius = {0.2f, 0.05f, 0.01f};
  RenderScene scene;
  scene.objects.push_back(render_object(make_block({0, 0, 0}, {4, 4, 4}), look));
  scene.objects.push_back(
      render_object(moved(make_block({0, 0, 0}, {2, 8, 0.02}), {1.0, 0, 2.02}), {.base_color = {0, 0, 0}}));
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.lights.push_back(
      {.corner = {-1, -1, 60}, .edge_u = {0, 2, 0}, .edge_v = {2, 0, 0}, .radiance = {900, 900, 900}});
  // seen from below the shade, 0.1 from its edge
  scene.camera = {.position = {0.1f, 0, 2.008f}, .target = {0.1f, 0, 0}, .vertical_fov_degrees = 40};
  const Eigen::Vector3d seen =
      mean_of(path_trace(scene, {.width = 8, .height = 8, .samples = 512, .bounces = 0}).color);
  CAPTURE(seen.transpose());
  CHECK(seen.x() > 1.6 * seen.y());
  CHECK(seen.y() > 6 * seen.z());
}

TEST_CASE("pictures with matter are the same bits for one thread and two, and for any part of them") {
  RenderScene scene = sphere_on_floor();
  scene.camera.position = {0, 2, 6};
  scene.objects[0].look.transmission = 0.5f;
  scene.objects[0].look.subsurface = 0.7f;
  PathTraceOptions options{.width = 60, .height = 40, .samples = 4};
  TracedImage one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = path_trace(scene, options);
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
  const TracedImage two = path_trace(scene, options);
  CHECK(one.color.values == two.color.values);
  CHECK(one.albedo.values == two.albedo.values);
  options.crop = Crop{.x0 = 17, .y0 = 5, .x1 = 44, .y1 = 33};
  const TracedImage part = path_trace(scene, options);
  CHECK(is_part_of(one.color, *options.crop, part.color));
}

TEST_CASE("bodies without matter are the same bits beside one that has it and is out of sight") {
  RenderScene scene = sphere_on_floor();
  scene.camera.position = {0, 2, 6};
  Look glass;
  glass.transmission = 1;
  scene.objects.push_back(render_object(moved(unit_sphere(1), {0, -50, 0}), {}));
  const TracedImage without = path_trace(scene, {.width = 32, .height = 24, .samples = 4});
  scene.objects[2].look = glass;
  CHECK(path_trace(scene, {.width = 32, .height = 24, .samples = 4}).color.values == without.color.values);
}

TEST_CASE("what is seen through clear matter guides the filter, not the matter before it") {
  // a glass pane before two floors of other colours
  RenderScene scene;
  Look glass{.base_color = {1, 1, 1}, .roughness = 0};
  glass.transmission = 1;
  scene.objects.push_back(render_object(moved(slab(3, 0.1), {0, 0, 2}), glass));
  scene.objects.push_back(
      render_object(moved(make_block({0, 0, 0}, {4, 4, 0.1}), {-2, 0, 0}), {.base_color = {0.8f, 0.1f, 0.1f}}));
  scene.objects.push_back(
      render_object(moved(make_block({0, 0, 0}, {4, 4, 0.1}), {2, 0, 0}), {.base_color = {0.1f, 0.1f, 0.8f}}));
  scene.camera = {.position = {0, 0, 6}, .target = {0, 0, 0}, .vertical_fov_degrees = 20};
  const TracedImage seen = path_trace(scene, {.width = 32, .height = 16, .samples = 64});
  CHECK(seen.albedo.pixel(4, 8)[0] > 2 * seen.albedo.pixel(4, 8)[2]);
  CHECK(seen.albedo.pixel(27, 8)[2] > 2 * seen.albedo.pixel(27, 8)[0]);
  // frosted glass guides by itself
  scene.objects[0].look.roughness = 0.6f;
  const TracedImage frosted = path_trace(scene, {.width = 32, .height = 16, .samples = 64});
  CHECK(frosted.albedo.pixel(4, 8)[0] == Approx(double(frosted.albedo.pixel(27, 8)[0])).margin(0.01));
}

TEST_CASE("light of other frames is not gathered where something is seen through the surface") {
  RenderScene scene = sphere_on_floor();
  scene.camera.position = {0, 2, 6};
  scene.objects[0].look.transmission = 1;
  const auto frame_of = [](const RenderScene& shown) {
    const RayScene rays(shown);
    return make_clip_frame(find_first_hits(rays, shown, 48, 32), shown,
                           path_trace(rays, shown, {.width = 48, .height = 32, .samples = 4}));
  };
  // another frame under other light, which is taken for the same where surfaces are the same
  const ClipFrame here = frame_of(scene), there = frame_of(scene);
  ClipFrame brighter = there;
  for (SeenPoint& point : brighter.points)
    for (int c = 0; c < 3; ++c) point.first[c] *= 1.001f, point.second[c] *= 1.001f;
  const NoisyLight alone = gather_light({&here}, 0), gathered = gather_light({&here, &brighter}, 0);
  int on_glass = 0, elsewhere = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x) {
      const SeenPoint& point = here.point(x, y);
      if (point.object == Hit::nothing) continue;
      const std::size_t i = std::size_t(y) * 48 + x;
      (point.object == 0 ? on_glass : elsewhere)++;
      if (point.object == 0) CHECK(gathered.light[1][i] == alone.light[1][i]);
      if (point.object != 0 && std::isfinite(point.distance)) CHECK(gathered.light[1][i] > alone.light[1][i]);
    }
  CHECK(on_glass > 50);
  CHECK(elsewhere > 50);
}

TEST_CASE("matter outside its range is refused by name") {
  Look look;
  SECTION("transmission") {
    look.transmission = 1.5f;
  }
  SECTION("subsurface") {
    look.subsurface = -0.1f;
  }
  SECTION("depth") {
    look.transmission_depth = 0;
  }
  SECTION("radius") {
    look.subsurface_radius.y() = 0;
  }
  CHECK_THROWS_AS(make_matter(look, "body"), Error);
}

TEST_CASE("the rasteriser shows clear bodies as bright as what is around them, and cloudy ones soft") {
  RenderScene scene = furnace(unit_sphere(4), {.base_color = {1, 1, 1}});
  scene.objects[0].look.transmission = 1;
  const Image clear = rasterize(scene, {.width = 64, .height = 64});
  CHECK(double(clear.pixel(32, 32)[1]) == Approx(1).margin(0.05));
  // lit from the left alone: light gets to the right only in cloudy matter
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.lights.push_back({.corner = {-6, -1, -1}, .edge_u = {0, 2, 0}, .edge_v = {0, 0, 2}, .radiance = {20, 20, 20}});
  const auto far_side = [&](float subsurface) {
    scene.objects[0].look = {.base_color = {0.8f, 0.8f, 0.8f}};
    scene.objects[0].look.subsurface = subsurface;
    return rasterize(scene, {.width = 64, .height = 64}).pixel(44, 32)[1];
  };
  CHECK(far_side(1) > far_side(0) + 0.01f);
}

TEST_CASE("path-traced wax and glass look like their reference") {
  RenderScene scene = make_still_life();
  scene.objects[1].look.roughness = 0.1f;
  scene.objects[1].look.transmission = 1;
  scene.objects[1].look.base_color = {0.75f, 0.3f, 0.2f};
  scene.objects[1].look.transmission_depth = 0.5f;
  scene.objects[2].look.subsurface = 1;
  scene.objects[2].look.base_color = {0.25f, 0.5f, 0.75f};
  scene.objects[2].look.subsurface_radius = {0.02f, 0.05f, 0.1f};
  scene.objects[3].look.subsurface = 1;
  scene.objects[3].look.subsurface_radius = {0.1f, 0.05f, 0.03f};
  const TracedImage traced = path_trace(scene, {.width = 128, .height = 72, .samples = 64});
  const GoldenTolerance tolerance{.fail = 4, .percent = 3, .hard_fail = 96, .mean_flip = 0.02};
  check_golden("traced_matter", traced.color, scene, tolerance);
}
