#include "render/trace/denoise.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

// a flat, evenly lit picture of two materials that meet at x = split, with noise of a given size
TracedImage two_materials(int width, int height, int split, float noise) {
  TracedImage t = black_image(width, height);
  std::mt19937 random(3);
  const auto wobble = [&] { return noise * (float(random()) / float(std::mt19937::max()) * 2 - 1) * std::sqrt(3.0f); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float albedo = x < split ? 0.8f : 0.2f;
      const float first = 1 + std::sqrt(2.0f) * wobble(), second = 1 + std::sqrt(2.0f) * wobble();
      for (int c = 0; c < 3; ++c) {
        t.albedo.pixel(x, y)[c] = albedo;
        t.color.pixel(x, y)[c] = albedo * (first + second) / 2;
        t.half.pixel(x, y)[c] = albedo * first;
      }
      t.normal.pixel(x, y)[1] = 1;
      *t.depth.pixel(x, y) = 3;
      *t.variance.pixel(x, y) = noise * noise * albedo * albedo;
    }
  }
  return t;
}

double error_between(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) sum += std::pow(double(a.values[i] - b.values[i]), 2);
  return std::sqrt(sum / double(a.values.size()));
}

}  // namespace

TEST_CASE("a picture without noise stays as it is") {
  const TracedImage clean = two_materials(80, 70, 40, 0);
  const Image filtered = denoise(clean);
  CHECK(error_between(filtered, clean.color) < 1e-5);
}

TEST_CASE("noise goes, the edge between two materials stays") {
  const TracedImage noisy = two_materials(100, 90, 47, 0.15f), clean = two_materials(100, 90, 47, 0);
  const Image filtered = denoise(noisy);
  CHECK(error_between(filtered, clean.color) < 0.2 * error_between(noisy.color, clean.color));
  for (int y = 0; y < 90; ++y) {
    CHECK(filtered.pixel(46, y)[1] == Approx(0.8).epsilon(0.15));
    CHECK(filtered.pixel(47, y)[1] == Approx(0.2).epsilon(0.15));
  }
}

TEST_CASE("a shadow that no feature shows keeps its edge") {
  TracedImage t = two_materials(64, 64, 64, 0.05f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) {
        t.color.pixel(x, y)[c] *= 0.4f;
        t.half.pixel(x, y)[c] *= 0.4f;
      }
      *t.variance.pixel(x, y) *= 0.16f;
    }
  }
  const Image filtered = denoise(t);
  for (int y = 4; y < 60; ++y) {
    CHECK(filtered.pixel(31, y)[0] == Approx(0.8).epsilon(0.1));
    CHECK(filtered.pixel(32, y)[0] == Approx(0.32).epsilon(0.1));
  }
}

TEST_CASE("a traced picture comes much nearer to the converged one") {
  const RenderScene scene = sphere_on_floor();
  PathTraceOptions options{.width = 96, .height = 64, .samples = 256};
  const Image reference = path_trace(scene, options).color;
  options.samples = 8;
  options.seed = 5;
  const TracedImage noisy = path_trace(scene, options);
  CHECK(error_between(denoise(noisy), reference) < 0.65 * error_between(noisy.color, reference));
}

TEST_CASE("the filter gives the same bits for one thread and two") {
  const TracedImage noisy = two_materials(150, 70, 60, 0.2f);
  Image one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = denoise(noisy);
  }
  CHECK(one.values == denoise(noisy).values);
}

TEST_CASE("strength 0 leaves the picture alone") {
  const TracedImage noisy = two_materials(20, 20, 10, 0.2f);
  CHECK(denoise(noisy, {.strength = 0}).values == noisy.color.values);
}
