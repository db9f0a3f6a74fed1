#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "render/raster/rasterize.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr float pi = std::numbers::pi_v<float>;

/// A wall that faces the camera, 2 m x 2 m at z = depth.
TriangleMesh make_wall(double depth, double half_size = 1) {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  const double s = half_size;
  mesh.positions << -s, -s, depth, s, -s, depth, s, s, depth, -s, s, depth;
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  return mesh;
}

/// Looks along -z; one metre at z = 0 is a quarter of the picture's height.
RenderScene empty_scene() {
  RenderScene scene;
  scene.camera = {.position = {0, 0, 10}, .target = {0, 0, 0}, .vertical_fov_degrees = 2 * std::atan(0.2f) * 180 / pi};
  scene.sky = ConstantSky{{0, 0, 0}};
  return scene;
}

Look matt(const Vector3f& color) {
  return {.base_color = color, .roughness = 1, .ior = 1};
}

Vector3f at(const Image& image, int x, int y) {
  return Eigen::Map<const Vector3f>(image.pixel(x, y));
}

double covered(const Image& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.values.size(); i += 3) sum += double(image.values[i]);
  return sum / double(image.values.size() / 3);
}

Rasterizer& shared_rasterizer() {
  static Rasterizer rasterizer;
  return rasterizer;
}
Image draw(const RenderScene& scene, int width, int height) {
  return shared_rasterizer().draw(scene, {.width = width, .height = height});
}

}  // namespace

TEST_CASE("a matt wall under an even sky has the radiance of the sky times its reflectance") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{0.5f, 1.0f, 2.0f}};
  scene.objects = {make_object("wall", make_wall(0), matt({0.8f, 0.4f, 0.2f}))};
  const Vector3f center = at(draw(scene, 40, 40), 20, 20);
  CHECK(center[0] == Approx(0.40).epsilon(0.04));
  CHECK(center[1] == Approx(0.40).epsilon(0.04));
  CHECK(center[2] == Approx(0.40).epsilon(0.04));
}

TEST_CASE("a matt wall before an area light has the radiance of the closed form") {
  RenderScene scene = empty_scene();
  scene.objects = {make_object("wall", make_wall(0), matt({0.5f, 0.5f, 0.5f}))};
  AreaLight light;
  light.corner = {-0.5f, -0.5f, 3};
  light.edge_u = {0, 1, 0};
  light.edge_v = {1, 0, 0};  // emits along -z
  light.radiance = {10, 10, 10};
  scene.lights = {light};
  // form factor of a parallel unit square seen from below its centre at distance 3: four quarters of 0.5 x 0.5
  const double x = 0.5 / 3, f = x / std::sqrt(1 + x * x);
  const double form_factor = 4 / (2 * std::numbers::pi) * (2 * f * std::atan(f));
  const Vector3f center = at(draw(scene, 41, 41), 20, 20);
  CHECK(center[0] == Approx(0.5 * 10 * form_factor).epsilon(0.02));
}

TEST_CASE("an occluder takes the light away behind it and nowhere else") {
  RenderScene scene = empty_scene();
  scene.objects = {make_object("wall", make_wall(0), matt({0.5f, 0.5f, 0.5f})),
                   make_object("screen", make_wall(1, 0.3), matt({0, 0, 0}))};
  const AreaLight light = make_square_light({2.5f, 0, 4.0f}, {0, 0, 0}, 0.2f, 100);
  scene.lights = {light};
  const Image image = draw(scene, 80, 80);
  // the screen's shadow is thrown to x = -0.83 m; the same place on the other side is lit
  const auto column = [](double metres) { return int(40 + metres * 20); };
  CHECK(at(image, column(-0.83), 40)[0] < 0.02f * at(image, column(0.6), 40)[0]);
  CHECK(at(image, column(-0.83), 25)[0] > 0.3f * at(image, column(0.6), 40)[0]);
}

TEST_CASE("coverage of a tilted wall equals its area to a fraction of a pixel") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{1, 1, 1}};
  scene.backdrop = Vector3f(0, 0, 0);
  TriangleMesh wall = make_wall(0);
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (int i = 0; i < 4; ++i) {
    const double x = wall.positions(i, 0), y = wall.positions(i, 1);
    wall.positions.row(i) << c * x - s * y, s * x + c * y, 0;
  }
  scene.objects = {make_object("wall", wall, matt({1, 1, 1}))};
  const Image image = draw(scene, 200, 200);
  const double inside = double(at(image, 100, 100)[0]);
  // edge pixels are blended with brighter parts weighing less, so the mean falls short by at most their share
  CHECK(covered(image) / inside == Approx(0.25).epsilon(0.01));
}

TEST_CASE("the nearer of two walls is seen, whatever their order") {
  for (const bool swapped : {false, true}) {
    RenderScene scene = empty_scene();
    scene.sky = ConstantSky{{1, 1, 1}};
    scene.objects = {make_object("near", make_wall(0.5), matt({1, 0, 0})),
                     make_object("far", make_wall(-0.5), matt({0, 1, 0}))};
    if (swapped) std::swap(scene.objects[0], scene.objects[1]);
    const Vector3f center = at(draw(scene, 20, 20), 10, 10);
    CHECK(center[0] > 0.5f);
    CHECK(center[1] < 0.01f);
  }
}

TEST_CASE("vertex colours and textures reach the picture, upright") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{1, 1, 1}};
  TriangleMesh painted = make_wall(0);
  painted.colors = Points::Constant(4, 3, 0.0);
  painted.colors.col(1).tail(2).setConstant(1.0);  // green at the top
  Look look = matt({1, 1, 1});
  look.vertex_colors = true;
  scene.objects = {make_object("painted", painted, look)};
  Image image = draw(scene, 40, 40);
  CHECK(at(image, 20, 12)[1] > 3 * at(image, 20, 28)[1]);
  CHECK(at(image, 20, 12)[0] < 0.01f);

  auto texture = std::make_shared<Image>(2, 2, 3);  // red above blue
  texture->values = {1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1};
  TriangleMesh textured = make_wall(0);
  textured.texture_coordinates.resize(6, 2);
  textured.texture_coordinates << 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1;
  look = matt({1, 1, 1});
  look.texture = texture;
  scene.objects = {make_object("textured", textured, look)};
  image = draw(scene, 40, 40);
  CHECK(at(image, 20, 14)[0] > 0.5f);
  CHECK(at(image, 20, 14)[2] < 0.1f);
  CHECK(at(image, 20, 26)[2] > 0.5f);
}

TEST_CASE("each triangle shows the paint of its material, with its texture") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{1, 1, 1}};
  TriangleMesh wall = make_wall(0);
  wall.materials = {1, 0};
  wall.texture_coordinates.setConstant(6, 2, 0.5f);
  auto blue = std::make_shared<Image>(1, 1, 3);
  blue->values = {0, 0, 1};
  Look look = matt({1, 1, 1});
  look.paints = {{{1, 0, 0}, nullptr}, {{1, 1, 1}, blue}};
  for (const bool smooth : {false, true}) {
    wall.normals = smooth ? Points(Vector3d(0, 0, 1).transpose().replicate(4, 1)) : Points();
    scene.objects = {make_object("wall", wall, look)};
    const Image image = draw(scene, 40, 40);
    const Vector3f below = at(image, 25, 25), above = at(image, 15, 15);  // of the diagonal
    CAPTURE(smooth, below.transpose(), above.transpose());
    CHECK(below[2] > 0.5f);
    CHECK(below[0] < 0.1f);
    CHECK(above[0] > 0.5f);
    CHECK(above[2] < 0.1f);
  }
}

TEST_CASE("a wire covers as many pixels as it is wide, at every angle") {
  for (const double angle : {0.0, 0.3, 0.7854}) {
    for (const float width : {1.0f, 2.0f, 5.0f}) {
      RenderScene scene = empty_scene();
      scene.backdrop = Vector3f(0, 0, 0);
      const auto c = float(std::cos(angle)), s = float(std::sin(angle));
      scene.wires = WireOverlay{.segments = {{{-c, -s, 0}, {c, s, 0}}}, .color = {1, 1, 1}, .width_pixels = width};
      const double ink = covered(draw(scene, 200, 200)) * 200 * 200;
      INFO("angle " << angle << ", width " << width);
      // a line of one pixel along the pixels' diagonals is sampled at its most uneven
      CHECK(ink == Approx(100.0 * double(width)).epsilon(width == 1.0f ? 0.14 : 0.06));
    }
  }
}

TEST_CASE("wires behind a surface are hidden, or faint when asked for") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{0, 0, 0}};
  scene.objects = {make_object("wall", make_wall(0), matt({0, 0, 0}))};
  WireOverlay wires{.segments = {{{-0.5f, 0, -1}, {0.5f, 0, -1}}}, .color = {1, 1, 1}, .width_pixels = 3};
  scene.wires = wires;
  CHECK(covered(draw(scene, 100, 100)) == 0.0);
  wires.hidden_lines = true;
  scene.wires = wires;
  const double faint = covered(draw(scene, 100, 100));
  wires.segments = {{{-0.5f, 0, 1}, {0.5f, 0, 1}}};
  scene.wires = wires;
  const double full = covered(draw(scene, 100, 100));
  CHECK(faint > 0.1 * full);
  CHECK(faint < 0.4 * full);
}

TEST_CASE("a second picture with the same context is the first one bit for bit") {
  const RenderScene scene = make_still_life();
  RenderScene other = empty_scene();
  other.objects = {make_object("wall", make_wall(0), matt({1, 1, 1}))};
  Rasterizer rasterizer;
  const Image first = rasterizer.draw(scene, {.width = 96, .height = 54});
  rasterizer.draw(other, {.width = 50, .height = 30});
  CHECK(rasterizer.draw(scene, {.width = 96, .height = 54}).values == first.values);
}

TEST_CASE("an empty scene shows its sky, and a mesh without triangles nothing") {
  RenderScene scene = empty_scene();
  scene.sky = ConstantSky{{0.25f, 0.5f, 1}};
  scene.objects = {make_object("nothing", TriangleMesh{}, {})};
  const Image image = draw(scene, 8, 8);
  CHECK(at(image, 4, 4)[1] == Approx(0.5f));
}

TEST_CASE("a camera that looks nowhere is refused, and normals that are none do no harm") {
  RenderScene scene = empty_scene();
  TriangleMesh wall = make_wall(0);
  wall.normals = Points::Constant(4, 3, std::nan(""));
  scene.sky = ConstantSky{{1, 1, 1}};
  scene.objects = {make_object("wall", wall, {.roughness = 0.3f, .clearcoat = 1})};
  const Image image = draw(scene, 20, 20);
  CHECK(std::all_of(image.values.begin(), image.values.end(), [](float value) { return std::isfinite(value); }));
  CHECK(at(image, 10, 10)[0] > 0.1f);
  scene.camera.target = scene.camera.position;
  CHECK_THROWS_AS(draw(scene, 20, 20), Error);
}

// Run by the next test in processes of their own too, for GL fixes its threads with the first context.
TEST_CASE("the still life's bits fill a file") {
  const char* threads = std::getenv("UMAX_TEST_THREADS");
  const char* path = std::getenv("UMAX_TEST_BITS");
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  threads ? std::size_t(std::atoi(threads)) : 2);
  const std::filesystem::path file = path ? std::filesystem::path(path) : output_folder() / "here.bits";
  const Image image = draw(make_still_life(), 160, 90);
  write_file(file, {reinterpret_cast<const char*>(image.values.data()), image.values.size() * sizeof(float)});
  CHECK(std::filesystem::file_size(file) == 160 * 90 * 3 * sizeof(float));
}

TEST_CASE("a picture is bit-identical for every number of threads and survives hostile driver settings") {
  const std::string self = UMAX_TEST_RENDER;
  const auto bits = [&](const std::string& environment) {
    const std::string path = (output_folder() / "child.bits").string();
    std::filesystem::remove(path);
    const std::string command = environment + " UMAX_TEST_BITS='" + path + "' '" + self +
                                "' \"the still life's bits fill a file\" >/dev/null 2>&1";
    INFO(command);
    REQUIRE(std::system(command.c_str()) == 0);
    return read_file(path);
  };
  const std::string one = bits("LP_NUM_THREADS=0 UMAX_TEST_THREADS=1");
  CHECK(bits("LP_NUM_THREADS=3 UMAX_TEST_THREADS=3") == one);
  CHECK(bits("LP_NATIVE_VECTOR_WIDTH=512 GALLIUM_DRIVER=swrast") == one);
}
