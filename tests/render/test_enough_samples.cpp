#include "render/trace/enough_samples.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "tests/support/catch.h"
#include "tests/support/golden.h"
#include "tests/support/picture_part.h"
#include "tests/support/render_shapes.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 64, height = 36;

TracedImage traced(const RenderScene& scene, int samples, double noise, unsigned seed = 1) {
  return path_trace(scene, {.width = width, .height = height, .samples = samples, .noise = noise, .seed = seed});
}

float luminance_at(const Image& image, std::size_t pixel) {
  const float* p = &image.values[3 * pixel];
  return luminance(p[0], p[1], p[2]);
}

double mean_samples(const TracedImage& image) {
  double sum = 0;
  for (const float samples : image.samples.values) sum += double(samples) / double(image.samples.values.size());
  return sum;
}

double light_of(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.values.size() / 3; ++i) sum += double(luminance_at(image, i));
  return sum;
}

RenderScene floor_under_hole() {
  TriangleMesh roof = moved(unit_sphere(5), {0, 0, 0}, 5);
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < roof.num_triangles(); ++t)
    if (roof.positions(roof.triangles(t, 0), 1) < 4.85) roof.triangles.row(kept++) = roof.triangles.row(t).eval();
  roof.triangles.conservativeResize(kept, 3);
  RenderScene scene;
  scene.objects.push_back(render_object(roof, {.base_color = {0, 0, 0}, .ior = 1}));
  scene.objects.push_back(render_object(floor_square(2), {.base_color = {0.8f, 0.8f, 0.8f}, .ior = 1}));
  scene.sky = ConstantSky{{4, 4, 4}};
  scene.camera = {.position = {0, 1.5f, 1.5f}, .target = {0, 0, 0}, .vertical_fov_degrees = 30};
  return scene;
}

PixelSum sum_of(std::initializer_list<float> luminances) {
  PixelSum sum;
  for (const float light : luminances) sum.add({.radiance = {light, light, light}}, sum.count);
  return sum;
}

}  // namespace

TEST_CASE("what a half needs is told by the other's paths, between the first ones and all") {
  const EnoughSamples enough(0.01, 256, 0);
  CHECK(enough.most() == 128);
  CHECK(enough.first() == 16);
  CHECK(enough.needed(sum_of({0.5f, 0.5f, 0.5f, 0.5f})) == enough.first());
  CHECK(enough.needed(sum_of({0, 0, 0, 0})) == enough.first());
  CHECK(enough.needed(sum_of({0, 0, 0, 4})) == enough.most());
  // nearly three times the paths for three fifths of the noise
  const PixelSum some = sum_of({0, 1, 0, 1, 1, 0, 0, 1});
  const EnoughSamples loose(0.005, 65536, 0), tight(0.003, 65536, 0);
  CHECK(loose.needed(some) > loose.first());
  CHECK(tight.needed(some) < tight.most());
  CHECK(tight.needed(some) == Approx(25.0 / 9 * loose.needed(some)).epsilon(1e-3));
  CHECK(EnoughSamples(0.01, 5, 0).first() == 3);
}

TEST_CASE("calm pixels take few samples, noisy ones many, none more than allowed") {
  const RenderScene scene = sphere_on_floor();
  const TracedImage image = traced(scene, 256, 0.02);
  const auto [least, most] = std::minmax_element(image.samples.values.begin(), image.samples.values.end());
  CHECK(*least == 32);
  CHECK(*most <= 256);
  CHECK(*most > 100);
  CHECK(mean_samples(image) < 150);
  CHECK(mean_samples(traced(scene, 256, 0.01)) > mean_samples(image));
  const TracedImage few = traced(scene, 16, 0.02);
  CHECK(std::all_of(few.samples.values.begin(), few.samples.values.end(), [](float n) { return n == 16; }));
}

TEST_CASE("pixels are as exact as asked") {
  const RenderScene scene = sphere_on_floor();
  const double noise = 0.02;
  const ShownLuminance shown(ToneMapOptions{});
  const TracedImage truth = traced(scene, 8192, 0), image = traced(scene, 1024, noise, 5);
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < image.samples.values.size(); ++i) {
    if (image.samples.values[i] >= 1024) continue;  // where the most was not enough
    const double is = double(shown(luminance_at(image.color, i))), should = double(shown(luminance_at(truth.color, i)));
    squares += std::pow((is - should) / std::max(should, 0.01), 2);
    ++count;
  }
  const double error = std::sqrt(squares / count);
  INFO("relative error " << error << " of " << count << " pixels, " << mean_samples(image) << " samples");
  CHECK(count > 0.9 * width * height);
  CHECK(error < 1.25 * noise);
  CHECK(error > 0.3 * noise);  // or samples are wasted
}

TEST_CASE("the mean of many pictures of few samples is the light of many samples: nothing is biased") {
  // a floor in the dark under a hole in the roof, which few paths find: a half that decided on itself would stop while
  // it has found nothing, and half of the light would be lost
  const RenderScene scene = floor_under_hole();
  PathTraceOptions options{.width = 32, .height = 18, .samples = 4096, .bounces = 1};
  const double truth = light_of(path_trace(scene, options).color);
  options.samples = 64;
  options.noise = 0.05;
  constexpr int pictures = 48;
  double sum = 0, squares = 0;
  for (int k = 0; k < pictures; ++k) {
    options.seed = unsigned(k) + 100;
    const TracedImage image = path_trace(scene, options);
    const auto [least, most] = std::minmax_element(image.samples.values.begin(), image.samples.values.end());
    CHECK((*least < *most));
    const double light = light_of(image.color);
    sum += light, squares += light * light;
  }
  const double mean = sum / pictures, error = std::sqrt((squares / pictures - mean * mean) / (pictures - 1));
  INFO("light " << mean << " for " << truth << ", standard error " << error);
  CHECK(error < 0.01 * truth);
  CHECK(std::abs(mean - truth) < 4 * error);
}

TEST_CASE("adaptive pictures are bit-identical for one thread and two, and for any part of them") {
  const RenderScene scene = sphere_on_floor();
  PathTraceOptions options{.width = 60, .height = 40, .samples = 64, .noise = 0.03};
  TracedImage one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = path_trace(scene, options);
  }
  const TracedImage two = path_trace(scene, options);
  CHECK(one.color.values == two.color.values);
  CHECK(one.samples.values == two.samples.values);
  options.crop = Crop{.x0 = 17, .y0 = 5, .x1 = 44, .y1 = 33};
  const TracedImage part = path_trace(scene, options);
  CHECK(is_part_of(one.color, *options.crop, part.color));
  CHECK(is_part_of(one.samples, *options.crop, part.samples));
}

TEST_CASE("an adaptive picture looks like its reference") {
  const RenderScene scene = make_still_life();
  const GoldenTolerance tolerance{.fail = 4, .percent = 3, .hard_fail = 96, .mean_flip = 0.02};
  const TracedImage image = path_trace(scene, {.width = 128, .height = 72, .samples = 256, .noise = 0.02});
  check_golden("traced_adaptive", image.color, scene, tolerance);
}

TEST_CASE("a noise that is none is refused") {
  const double noise = GENERATE(-0.1, 1.5, NAN);
  CHECK_THROWS_AS(path_trace(sphere_on_floor(), {.width = 8, .height = 8, .samples = 1, .noise = noise}), Error);
}
