// A ground that passes into what is seen at the horizon.
#include <algorithm>

#include "render/raster/rasterize.h"
#include "render/trace/cut_out.h"
#include "render/trace/path_trace.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int size = 33;  // [px]
constexpr float grey = 0.5f, sky = 0.8f, behind = 0.1f;

/// A matt floor under an even sky, seen from straight above: 4 m to each side of the middle.
RenderScene floor_from_above() {
  RenderScene scene;
  scene.objects.push_back(
      render_object(floor_square(20), {.base_color = {grey, grey, grey}, .roughness = 1, .ior = 1}));
  scene.sky = ConstantSky{{sky, sky, sky}};
  scene.backdrop = Vector3f(behind, behind, behind);
  scene.camera = {.position = {0, 20, 0}, .target = {0, 0, 0}, .up = {0, 0, -1}};
  scene.camera.vertical_fov_degrees = float(2 * std::atan(4.0 / 20) * 180 / M_PI);
  return scene;
}

TracedImage traced(const RenderScene& scene, int samples = 256) {
  return path_trace(scene, {.width = size, .height = size, .samples = samples, .bounces = 1});
}

float distance_of(int x, int y) {
  constexpr float metres = 8.0f / size, middle = 0.5f * (size - 1);
  return metres * Vector2f(float(x) - middle, float(y) - middle).norm();
}

/// A ball over a floor that the camera sees up to where it ends, below the horizon.
RenderScene ball_over_plane() {
  RenderScene scene = sphere_on_floor();
  scene.sky = GradientSky{.horizon = {0.3f, 0.4f, 0.5f}, .zenith = {0.1f, 0.2f, 0.9f}, .ground = {0.9f, 0.1f, 0.1f}};
  scene.camera = {.position = {0, 3, 7}, .target = {0, 2, 0}, .vertical_fov_degrees = 50};
  return scene;
}

}  // namespace

TEST_CASE("a ground that fades shows its share of light and the rest of what is behind, pixel by pixel") {
  RenderScene scene = floor_from_above();
  scene.objects[0].fade = Fade{.begin = 1, .end = 3};
  const TracedImage image = traced(scene);
  double error = 0;
  int between = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float share = scene.objects[0].fade->at({distance_of(x, y), 0, 0});
      between += share > 0.05f && share < 0.95f;
      const float wanted = (1 - share) * grey * sky + share * behind;
      error = std::max(error, double(std::abs(image.color.pixel(x, y)[0] - wanted)));
      CHECK(image.albedo.pixel(x, y)[0] == Approx((1 - share) * grey + share).margin(0.02));
    }
  CHECK(between > 100);
  CHECK(error < 0.01);
  // nothing of it is left to chance where it is gone
  for (const float value : {image.color.pixel(0, 0)[0], image.color.pixel(size - 1, 4)[2]}) CHECK(value == behind);
  CHECK(image.variance.pixel(0, 0)[0] == 0);
}

TEST_CASE("a ground fades neither for light nor where pictures are transparent or it catches shadows") {
  RenderScene scene = floor_from_above();
  const TracedImage without = traced(scene, 16);
  scene.objects[0].fade = Fade{.begin = 30, .end = 40};
  CHECK(traced(scene, 16).color.values == without.color.values);  // all that is seen is nearer

  scene.objects[0].fade = Fade{.begin = 0.1f, .end = 0.2f};
  const TracedImage transparent = traced(made_transparent(scene), 16);
  CHECK(transparent.alpha.pixel(0, 0)[0] == 1);
  CHECK(transparent.color.pixel(0, 0)[0] == Approx(grey * sky).epsilon(1e-4));

  RenderScene catcher = scene;
  catcher.objects[0].catches_shadows = true;
  CHECK_FALSE(has_fade(catcher));
  CHECK(has_fade(scene));

  // a ball is lit by a ground that the camera does not see any more
  RenderScene ball = ball_over_plane();
  const TracedImage lit = traced(ball, 64);
  ball.objects[1].fade = Fade{.begin = 0.01f, .end = 0.02f};
  const TracedImage still_lit = traced(ball, 64);
  const int x = size / 2, y = size / 2 + 3;  // its lower half
  CHECK(still_lit.color.pixel(x, y)[0] == Approx(lit.color.pixel(x, y)[0]).epsilon(1e-5));
}

TEST_CASE("where a ground fades, no horizon is seen by either renderer") {
  RenderScene scene = ball_over_plane();
  scene.objects[1].fade = Fade{.begin = 4, .end = 12};
  const auto largest_step = [&](const Image& picture) {
    float largest = 0;  // in the column at the left edge, from row to row, far from the ball
    for (int y = 0; y + 1 < picture.height; ++y)
      largest = std::max(largest, std::abs(picture.pixel(1, y)[2] - picture.pixel(1, y + 1)[2]));
    return largest;
  };
  const auto traced_picture = [](const RenderScene& shown) {
    return path_trace(shown, {.width = 120, .height = 120, .samples = 256, .bounces = 1}).color;
  };
  RenderScene without = scene;
  without.objects[1].fade.reset();
  CHECK(largest_step(traced_picture(without)) > 0.07f);
  CHECK(largest_step(traced_picture(scene)) < 0.02f);

  // the rasteriser fades as the scene says, in place of its own way
  RenderScene near = floor_from_above(), far = near;
  for (RenderScene* shown : {&near, &far})
    shown->objects.push_back(render_object(moved(unit_sphere(3), {0, 0.2, 0}, 0.2)));
  near.objects[0].fade = Fade{.begin = 0.5f, .end = 1};
  far.objects[0].fade = Fade{.begin = 15, .end = 19};
  const RasterizeOptions small{.width = size, .height = size};
  const Image faded = rasterize(near, small), whole = rasterize(far, small);
  const float left = faded.pixel(2, size / 2)[0], there = whole.pixel(2, size / 2)[0];
  CHECK(left == Approx(behind).margin(0.01));
  CHECK(there > 2 * behind);
}
