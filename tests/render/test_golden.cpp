#include <Eigen/Geometry>

#include "core/files/read_file.h"
#include "render/image/colormap.h"
#include "render/raster/rasterize.h"
#include "render/trace/path_trace.h"
#include "tests/support/golden.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

Image8 plain(int width, int height, std::uint8_t code) {
  Image8 image(width, height, 3);
  std::fill(image.values.begin(), image.values.end(), code);
  return image;
}

}  // namespace

TEST_CASE("a picture that differs fails in each of the four ways and leaves a page with the command") {
  const GoldenTolerance strict{.fail = 3, .percent = 1, .hard_fail = 48, .mean_flip = 0.01};
  const Image8 reference = plain(40, 40, 100);
  const std::filesystem::path folder = output_folder() / "pages";
  const auto outcome = [&](const Image8& result) {
    return compare_with_golden("scratch", reference, result, strict, folder);
  };
  CHECK(outcome(reference).passed);
  CHECK(outcome(plain(40, 40, 101)).passed == (flip(reference, plain(40, 40, 101)).mean <= 0.01));

  Image8 few = reference;  // 1 % of the pixels: allowed; one more: not
  for (int i = 0; i < 16; ++i) few.pixel(2 * (i % 4), 2 * (i / 4))[1] = 106;
  CHECK(outcome(few).passed);
  few.pixel(30, 30)[1] = 106;
  CHECK_FALSE(outcome(few).passed);

  Image8 one = reference;
  one.pixel(20, 20)[0] = 160;
  CHECK_FALSE(outcome(one).passed);

  std::filesystem::remove_all(folder);
  const GoldenOutcome failed = outcome(plain(40, 40, 200));
  CHECK_FALSE(failed.passed);
  const std::string page = read_file(failed.page);
  CHECK(page.find("cp '" + (folder / "scratch.png").string()) != std::string::npos);
  CHECK(read_png8(folder / "scratch.png").values == plain(40, 40, 200).values);
}

TEST_CASE("rasterised pictures look like their references") {
  const RasterizeOptions small{.width = 160, .height = 90};
  RenderScene scene = make_still_life();
  SECTION("still life") {
    check_golden("raster_still_life", rasterize(scene, small), scene);
  }
  SECTION("under the sun") {
    scene.lights.clear();
    scene.sky = DaylightSky{.sun_direction = {0.6f, 0.55f, 0.5f}, .sun_size_degrees = 3};
    check_golden("raster_daylight", rasterize(scene, small), scene);
  }
  SECTION("heat map with wires") {
    TriangleMesh ball = make_ball({0, 0.8, 0}, 0.8);
    ball.colors.resize(ball.num_vertices(), 3);
    for (Eigen::Index i = 0; i < ball.num_vertices(); ++i)
      ball.colors.row(i) = color_of_value(1.05 - ball.positions(i, 1) / 1.6).cast<double>().transpose();
    scene.objects.resize(1);
    scene.objects.push_back(make_object("ball", ball, {.roughness = 0.6f, .vertex_colors = true}));
    WireOverlay wires{.segments = {}, .width_pixels = 1, .hidden_lines = true};
    for (int i = 0; i < 8; ++i) {
      for (const int axis : {1, 2, 4}) {
        if (i & axis) continue;
        const auto corner = [](int k) {
          return Vector3f(k & 1 ? 0.85f : -0.85f, k & 2 ? 1.65f : 0.02f, k & 4 ? 0.85f : -0.85f);
        };
        wires.segments.push_back({corner(i), corner(i | axis)});
      }
    }
    scene.wires = wires;
    scene.legend = Legend{.title = "U / Umax", .ends_at_limit = true};
    scene.camera.target = {0.3f, 0.8f, 0};
    const Image linear = rasterize(scene, small);
    scene.legend.reset();  // its letters are hinted otherwise by every FreeType: test_annotate holds the legend
    check_golden("raster_heat_map", linear, scene, {.percent = 3, .mean_flip = 0.02});
  }
}

TEST_CASE("path-traced pictures look like their references") {
  const RenderScene scene = make_still_life();
  // another instruction set draws other ray hits on edges, and with them other noise in single pixels
  const GoldenTolerance tolerance{.fail = 4, .percent = 3, .hard_fail = 96, .mean_flip = 0.02};
  const TracedImage traced = path_trace(scene, {.width = 128, .height = 72, .samples = 64});
  check_golden("traced_still_life", traced.color, scene, tolerance);
}

TEST_CASE("both renderers show a matt scene alike") {
  RenderScene scene = make_still_life();
  scene.objects[0] = make_object("floor", make_floor(4), scene.objects[0].look);  // too small to pass into the sky
  for (RenderObject& object : scene.objects) {
    object.look.roughness = 1;
    object.look.clearcoat = 0;
  }
  const Image8 traced = present(path_trace(scene, {.width = 128, .height = 72, .samples = 64}).color, scene);
  const Image8 drawn = present(rasterize(scene, {.width = 128, .height = 72}), scene);
  const FlipResult difference = flip(traced, drawn);
  INFO("mean FLIP " << difference.mean);
  CHECK(difference.mean < 0.08);
}
