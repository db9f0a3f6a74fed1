// Pictures with alpha, and surfaces that show nothing but the shadows on them.
#include "render/trace/cut_out.h"

#include <tbb/global_control.h>

#include <cmath>

#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 48, height = 36;

/// A sphere above a floor that catches its shadow, under a lamp.
RenderScene sphere_over_catcher() {
  RenderScene scene = sphere_on_floor();
  scene.objects[0].mesh = std::make_shared<const TriangleMesh>(moved(unit_sphere(4), {0, 1.2, 0}, 0.6));
  scene.objects[1].catches_shadows = true;
  scene.camera = {.position = {0, 3, 7}, .target = {0, 0.6f, 0}, .vertical_fov_degrees = 40};
  scene.sky = ConstantSky{{0, 0, 0}};
  return scene;
}

PathTraceOptions few_paths() {
  return {.width = width, .height = height, .samples = 64, .bounces = 0};
}

TracedImage cut_out(const RenderScene& scene, const PathTraceOptions& options, bool denoised = false) {
  TracedImage image = path_trace(made_transparent(scene), options);
  finish_cut_out(scene, options, denoised, image);
  return image;
}

/// Largest difference of a layer over a plate and a picture.
double error_over(const TracedImage& layer, const Image& plate, const Image& wanted) {
  double largest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double over =
            double(layer.color.pixel(x, y)[c]) + (1 - double(*layer.alpha.pixel(x, y))) * double(plate.pixel(x, y)[c]);
        largest = std::max(largest, std::abs(over - double(wanted.pixel(x, y)[c])));
      }
  return largest;
}

}  // namespace

TEST_CASE("a shadow over the picture of the floor alone is the picture of both") {
  RenderScene scene = sphere_over_catcher();
  scene.objects[1].look = {.base_color = {0.4f, 0.4f, 0.4f}, .roughness = 1, .ior = 1};
  scene.lights[0].radiance = {20, 20, 20};
  scene.transparent = true;
  const TracedImage layer = cut_out(scene, few_paths());

  RenderScene both = scene, floor = scene;
  for (RenderScene* one : {&both, &floor})
    for (RenderObject& object : one->objects) object.catches_shadows = false;
  floor.objects.erase(floor.objects.begin());
  const Image plate = path_trace(floor, few_paths()).color, wanted = path_trace(both, few_paths()).color;
  CHECK(error_over(layer, plate, wanted) < 0.02);

  double darkest = 0, clear = 0, object = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double alpha = double(*layer.alpha.pixel(x, y)), light = double(layer.color.pixel(x, y)[0]);
      if (light == 0) darkest = std::max(darkest, alpha);
      clear += alpha == 0 ? 1 : 0;
      object += alpha == 1 && light > 0 ? 1 : 0;
    }
  CHECK(darkest > 0.9);               // the core of the shadow
  CHECK(clear > width * height / 2);  // exactly nothing where there is no shadow
  CHECK(object > 20);
}

TEST_CASE("an opaque picture shows what is behind the catcher, darker in the shadow") {
  RenderScene scene = sphere_over_catcher();
  scene.backdrop = Vector3f(0.2f, 0.4f, 0.8f);
  const TracedImage image = cut_out(scene, few_paths());
  scene.transparent = true;
  const TracedImage layer = cut_out(scene, few_paths());
  Image plate(width, height);
  for (std::size_t i = 0; i < plate.values.size(); ++i) plate.values[i] = (*scene.backdrop)[Eigen::Index(i % 3)];
  CHECK(error_over(layer, plate, image.color) < 1e-4);
  CHECK(image.color.pixel(1, height - 2)[2] == Approx(0.8));
  // without noise away from objects, and with less near them
  const TracedImage calm = cut_out(scene, few_paths(), true);
  CHECK(*calm.alpha.pixel(1, height - 2) == 0);
  double difference = 0;
  for (std::size_t i = 0; i < calm.alpha.values.size(); ++i)
    difference += std::abs(double(calm.alpha.values[i] - layer.alpha.values[i]));
  CHECK(difference > 0);
  CHECK(difference / double(calm.alpha.values.size()) < 0.02);
}

TEST_CASE(
    "shadows are the same for any number of threads, for a part of the picture, and with as many paths as it takes") {
  RenderScene scene = sphere_over_catcher();
  scene.transparent = true;
  PathTraceOptions options = few_paths();
  options.samples = 16;
  const TracedImage whole = cut_out(scene, options);
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    CHECK(cut_out(scene, options).alpha.values == whole.alpha.values);
  }
  options.crop = Crop{.x0 = 10, .y0 = 11, .x1 = 40, .y1 = 30};
  CHECK(*cut_out(scene, options).alpha.pixel(9, 12) == *whole.alpha.pixel(19, 23));

  options = few_paths();
  const TracedImage all = cut_out(scene, options);
  options.noise = 0.01;
  const TracedImage enough = cut_out(scene, options);
  double difference = 0;
  for (std::size_t i = 0; i < all.alpha.values.size(); ++i)
    difference += std::abs(double(all.alpha.values[i] - enough.alpha.values[i]));
  CHECK(difference / double(all.alpha.values.size()) < 0.01);
}

TEST_CASE("the filter leaves no light outside of what covers its pixels, and edges as bright as they are") {
  RenderScene scene = sphere_over_catcher();
  scene.objects.pop_back();
  scene.objects[0].look = {.base_color = {0.8f, 0.8f, 0.8f}, .roughness = 1, .ior = 1};
  scene.lights.clear();
  scene.sky = ConstantSky{{1, 1, 1}};  // every point of the ball is as bright as the other
  scene.transparent = true;
  PathTraceOptions options = few_paths();
  options.bounces = 1, options.samples = 8;
  const TracedImage image = cut_out(scene, options, true);
  int edge = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double alpha = double(*image.alpha.pixel(x, y)), light = double(image.color.pixel(x, y)[1]);
      if (alpha == 0) CHECK(light == 0);
      if (alpha > 0) CHECK(light / alpha == Approx(0.8).epsilon(0.02));
      edge += alpha > 0 && alpha < 1 ? 1 : 0;
    }
  CHECK(edge > 20);
}

TEST_CASE("the filter takes the noise out of what stands before a catcher") {
  RenderScene scene = sphere_over_catcher();
  scene.sky = ConstantSky{{0.6f, 0.6f, 0.7f}};
  scene.transparent = true;
  scene.camera = {.position = {0, 3, 7}, .target = {0, 1.2f, 0}, .vertical_fov_degrees = 12};
  PathTraceOptions options = few_paths();
  options.bounces = 2, options.samples = 1024;
  const TracedImage reference = cut_out(scene, options);
  options.samples = 16;
  const TracedImage noisy = cut_out(scene, options), calm = cut_out(scene, options, true);
  // of the ball, edges left out, which are noisy in alpha
  const auto error = [&](const TracedImage& image) {
    double squares = 0;
    for (std::size_t i = 0; i < reference.alpha.values.size(); ++i) {
      if (reference.color.values[3 * i] < 0.02f || reference.alpha.values[i] < 0.98f) continue;
      squares += std::pow(double(image.color.values[3 * i + 1] - reference.color.values[3 * i + 1]), 2);
    }
    return std::sqrt(squares);
  };
  CAPTURE(error(calm), error(noisy));
  CHECK(error(calm) < 0.8 * error(noisy));
}

TEST_CASE("nothing is caught where nothing catches") {
  const RenderScene scene = sphere_on_floor();
  CHECK_FALSE(has_shadow_catchers(scene));
  CHECK_FALSE(path_trace(scene, few_paths()).caught);
}
