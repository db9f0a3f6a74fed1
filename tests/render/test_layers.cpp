// Layers for compositing: mattes by name, data of what is seen, alpha, and what an EXR says of them.
#include <tbb/global_control.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/files/read_file.h"
#include "render/image/cryptomatte.h"
#include "render/scene/camera.h"
#include "render/trace/path_trace.h"
#include "render/trace/surface_data.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr int width = 60, height = 40;

/// Upright square of half edge `half` at depth z, facing the camera.
TriangleMesh wall(double half, const Vector3d& middle) {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  mesh.positions << -half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0;
  mesh.positions.rowwise() += middle.transpose();
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  return mesh;
}

/// A camera at z = 4 that sees 4 m x 6 m at z = 0: 10 px are 1 m.
Camera front_camera() {
  return {.position = {0, 0, 4},
          .target = {0, 0, 0},
          .vertical_fov_degrees = 2 * std::atan(0.5f) * 180 / std::numbers::pi_v<float>};
}

/// The right half of the picture is a wall.
RenderScene half_wall(double left = 0) {
  RenderScene scene;
  scene.objects.push_back(render_object(wall(10, {10 + left, 0, 0})));
  scene.objects.front().name = "wall";
  scene.backdrop = Vector3f(0.3f, 0.5f, 0.7f);
  scene.camera = front_camera();
  return scene;
}

/// Share of a number in a pixel of pairs.
float share_of(const Image& pairs, int x, int y, float number) {
  float share = 0;
  for (int rank = 0; rank < matte_ranks; ++rank)
    if (const float* pair = pairs.pixel(x, y) + 2 * rank; pair[0] == number) share += pair[1];
  return share;
}

/// The values of a matrix attribute, as the file has them.
std::array<float, 16> matrix_in(const std::string& bytes, const std::string& name) {
  const std::string start = name + std::string("\0m44f\0\x40\0\0\0", 10);
  const std::size_t at = bytes.find(start);
  REQUIRE(at != bytes.npos);
  std::array<float, 16> values{};
  std::memcpy(values.data(), bytes.data() + at + start.size(), sizeof values);
  return values;
}

}  // namespace

TEST_CASE("names have the numbers that Cryptomatte gives them") {
  CHECK(murmur_hash_32("torus") == 4053562365u);
  CHECK(cryptomatte_bits("torus") == 0xf19c73fdu);
  CHECK(cryptomatte_number("torus") == Approx(-1.549436e30).epsilon(1e-6));
  CHECK(cryptomatte_bits("bunny") == 0x13851a76u);
  // published vectors of MurmurHash3_x86_32 with every length of the rest
  CHECK(murmur_hash_32("") == 0);
  CHECK(murmur_hash_32("a") == 0x3c2569b2u);
  CHECK(murmur_hash_32("ab") == 0x9bbfd75fu);
  CHECK(murmur_hash_32("abc") == 0xb3dd93fau);
  CHECK(murmur_hash_32("abcd") == 0x43ed676au);
  CHECK(murmur_hash_32("The quick brown fox jumps over the lazy dog") == 0x2e4ff723u);
  CHECK(murmur_hash_32("Hello, world!") == 0xc0363e43u);

  int clamped = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::string name = "thing" + std::to_string(i);
    CHECK(std::isnormal(cryptomatte_number(name)));
    if (cryptomatte_bits(name) == murmur_hash_32(name)) continue;
    ++clamped;
    CHECK((cryptomatte_bits(name) ^ murmur_hash_32(name)) == 1u << 23);
  }
  CHECK(clamped > 5);
}

TEST_CASE("the header tells the names of mattes") {
  const ExrTexts texts = cryptomatte_texts("CryptoObject", {"torus", "a \"b\"\\\n", "bunny", "torus"});
  REQUIRE(texts.size() == 4);
  const auto text = [&](const std::string& key) {
    const auto found = std::find_if(texts.begin(), texts.end(),
                                    [&](const auto& one) { return one.first == "cryptomatte/3ae39a5/" + key; });
    return found == texts.end() ? std::string("none") : found->second;
  };
  CHECK(text("name") == "CryptoObject");
  CHECK(text("hash") == "MurmurHash3_32");
  CHECK(text("conversion") == "uint32_to_float32");
  const std::string odd = text("manifest");
  CHECK(odd.find(R"("torus":"f19c73fd")") != odd.npos);
  CHECK(odd.find(R"("bunny":"13851a76")") != odd.npos);
  CHECK(odd.find(R"("a \"b\"\\\u000a":)") != odd.npos);
  CHECK(odd.find("torus", odd.find("torus") + 1) == odd.npos);
}

TEST_CASE("mattes tell which share of a pixel each part has, and alpha what they all have") {
  RenderScene scene = half_wall(0.03);  // the edge goes through column 30, at 0.3 of it
  auto mesh = std::make_shared<TriangleMesh>(wall(2.5, {2.53, 0, 0}));
  mesh->materials = {0, 1};
  scene.objects[0].mesh = mesh;
  scene.objects[0].look.paints = {Paint{}, Paint{}};
  PathTraceOptions options{.width = width, .height = height, .samples = 256, .bounces = 0};
  options.mattes = {{{7, 7}}, {{1, 2}}};
  for (const double noise : {0.0, 0.05}) {
    options.noise = noise;
    const TracedImage image = path_trace(scene, options);
    REQUIRE(image.mattes.size() == 2);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const float all = share_of(image.mattes[0], x, y, 7), alpha = *image.alpha.pixel(x, y);
        CHECK(all == Approx(alpha).margin(1e-6));
        CHECK(share_of(image.mattes[1], x, y, 1) + share_of(image.mattes[1], x, y, 2) == Approx(alpha).margin(1e-6));
        if (x < 28) CHECK(alpha == 0);
        if (x > 32) CHECK(alpha == 1);
        // by falling share
        const float* ranks = image.mattes[1].pixel(x, y);
        CHECK(ranks[1] >= ranks[3]);
      }
    CHECK(share_of(image.mattes[1], 50, 35, 1) == 1);  // the lower right triangle
    CHECK(share_of(image.mattes[1], 32, 1, 2) == 1);
    // coverage under the filter, whose sum over the row is the wall's extent
    double covered = 0;
    for (int x = 20; x < 40; ++x) covered += double(*image.alpha.pixel(x, 20));
    CHECK(covered == Approx(9.7).margin(0.1));
  }
}

TEST_CASE("mattes are the same for any number of threads and for a part of the picture") {
  RenderScene scene = sphere_on_floor();
  scene.camera.target = {0, 0.8f, 0};
  PathTraceOptions options{.width = 50, .height = 40, .samples = 8, .mattes = {{{3}, {5}}}};
  const TracedImage whole = path_trace(scene, options);
  TracedImage one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = path_trace(scene, options);
  }
  CHECK(one.mattes[0].values == whole.mattes[0].values);
  CHECK(one.alpha.values == whole.alpha.values);
  options.crop = Crop{.x0 = 13, .y0 = 7, .x1 = 40, .y1 = 33};
  const TracedImage part = path_trace(scene, options);
  for (int c = 0; c < 2 * matte_ranks; ++c) CHECK(part.mattes[0].pixel(5, 9)[c] == whole.mattes[0].pixel(18, 16)[c]);
}

TEST_CASE("a transparent picture over its backdrop is the picture with that backdrop") {
  RenderScene scene = half_wall(0.03);
  const PathTraceOptions options{.width = width, .height = height, .samples = 32};
  const TracedImage opaque = path_trace(scene, options);
  scene.transparent = true;
  const TracedImage clear = path_trace(scene, options);
  CHECK(clear.alpha.values == opaque.alpha.values);
  double largest = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        largest = std::max(largest, double(std::abs(clear.color.pixel(x, y)[c] +
                                                    (1 - *clear.alpha.pixel(x, y)) * (*scene.backdrop)[c] -
                                                    opaque.color.pixel(x, y)[c])));
  CHECK(largest < 1e-5);
  CHECK(clear.color.pixel(2, 2)[0] == 0);
}

TEST_CASE("depth is planar, and data of the pixel's middle are not averaged") {
  RenderScene scene = half_wall(0.03);
  scene.objects.push_back(render_object(wall(10, {0, 0, -2})));
  scene.objects[0].values = {0, 2, 2, 0};  // grows to the right: 2 over 20 m
  const RayScene rays(scene);
  const SurfaceData data = find_surface_data(rays, scene, width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool near = x >= 30 + (0.3 < 0.5 ? 0 : 1);
      CHECK(*data.object.pixel(x, y) == (near ? 1 : 2));
      CHECK(*data.depth.pixel(x, y) == Approx(near ? 4 : 6).epsilon(1e-5));
      const double scale = near ? 0.1 : 0.15;  // [m/px]
      CHECK(data.position.pixel(x, y)[0] == Approx((x + 0.5 - 30) * scale).margin(1e-4));
      CHECK(data.position.pixel(x, y)[1] == Approx((20 - y - 0.5) * scale).margin(1e-4));
      CHECK(data.position.pixel(x, y)[2] == Approx(near ? 0 : -2).margin(1e-5));
      CHECK(*data.value.pixel(x, y) == Approx(near ? ((x + 0.5 - 30) * 0.1 - 0.03) / 10 : 0).margin(1e-5));
      for (int c = 0; c < 4; ++c) CHECK(data.motion.pixel(x, y)[c] == 0);
    }
  scene.objects.pop_back();
  const SurfaceData alone = find_surface_data(RayScene(scene), scene, width, height);
  CHECK(*alone.depth.pixel(3, 3) == depth_of_nothing);
  CHECK(*alone.object.pixel(3, 3) == 0);
}

TEST_CASE("motion vectors tell where points were and will be, in pixels to the right and up") {
  RenderScene scene = half_wall(-8);
  const auto at = [&](const Vector3d& by) {
    return std::make_shared<const TriangleMesh>(moved(*scene.objects[0].mesh, by));
  };
  scene.objects[0].previous = at({-0.5, 0.2, 0});
  scene.objects[0].next = at({0.3, 0.7, 0});
  const auto motion_at = [&](int x, int y) {
    const SurfaceData data = find_surface_data(RayScene(scene), scene, width, height);
    return Eigen::Vector4f(data.motion.pixel(x, y));
  };
  CHECK((motion_at(40, 11) - Eigen::Vector4f(-5, 2, -3, -7)).norm() < 1e-3f);

  // towards the camera: away from the middle
  scene.objects[0].previous = nullptr;
  scene.objects[0].next = at({0, 0, 2});
  CHECK((motion_at(40, 11) - Eigen::Vector4f(0, 0, -10.5f, -8.5f)).norm() < 1e-3f);
  // behind it: nowhere
  scene.objects[0].next = at({0, 0, 5});
  CHECK(motion_at(40, 11).norm() == 0);

  // a camera that goes to the right moves what stands still to the left
  scene.objects[0].next = nullptr;
  scene.previous_camera = scene.next_camera = scene.camera;
  scene.next_camera->position.x() += 1, scene.next_camera->target.x() += 1;
  CHECK((motion_at(40, 11) - Eigen::Vector4f(0, 0, 10, 0)).norm() < 1e-3f);
}

TEST_CASE("data are those of the picture's own moment while the shutter is open") {
  RenderScene scene = half_wall(0);
  const TriangleMesh mesh = *scene.objects[0].mesh;
  for (const double x : {-1.0, 1.0})
    scene.objects[0].motion.instants.push_back(std::make_shared<const TriangleMesh>(moved(mesh, {x, 0, 0})));
  const auto first_column = [&](float moment) {
    scene.moment = moment;
    const SurfaceData data = find_surface_data(RayScene(scene), scene, width, height);
    int x = 0;
    while (*data.object.pixel(x, 20) == 0) ++x;
    return x;
  };
  CHECK(first_column(0) == 20);
  CHECK(first_column(0.5f) == 30);
  CHECK(first_column(1) == 40);
}

TEST_CASE("an EXR keeps vectors, mattes and matrices under the names of the trade") {
  const TemporaryFolder folder;
  const auto path = folder / "layers.exr";
  Image vector(5, 3, 4), pairs(5, 3, 12), one(5, 3, 1);
  for (Image* image : {&vector, &pairs, &one})
    for (std::size_t i = 0; i < image->values.size(); ++i) image->values[i] = float(i) - 7;
  std::vector<Layer> layers{{"", Image(5, 3, 4)}, {"Vector", vector}, {"Object.X", one}};
  for (const Layer& layer : cryptomatte_layers("CryptoObject", pairs)) layers.push_back(layer);
  ExrHeader header{.is_rec709 = true, .world_to_camera = Eigen::Matrix4f::Identity()};
  (*header.world_to_camera)(0, 3) = 5;  // a shift, of column vectors
  write_exr(path, layers, header);

  const std::string bytes = read_file(path);
  for (const char* name : {"Vector.W", "Object.X", "CryptoObject00.r", "CryptoObject02.a", "chromaticities"})
    CHECK(bytes.find(name) != bytes.npos);
  CHECK(matrix_in(bytes, "worldToCamera")[12] == 5);  // of row vectors
  CHECK(matrix_in(bytes, "worldToCamera")[3] == 0);
  const std::vector<Layer> back = read_exr(path);
  const auto layer = [&](const std::string& name) {
    for (const Layer& found : back)
      if (found.name == name) return found.image;
    return Image();
  };
  CHECK(layer("Vector").values == vector.values);
  CHECK(layer("Object").values == one.values);
  REQUIRE(layer("CryptoObject01").channels == 4);
  CHECK(layer("CryptoObject01").pixel(2, 1)[0] == pairs.pixel(2, 1)[4]);

  write_exr(path, {{"", Image(5, 3, 3)}});  // nothing of this where nobody asks
  for (const char* name : {"chromaticities", "worldToCamera"}) CHECK(read_file(path).find(name) == std::string::npos);
}
