// Cameras and lights that move: by keys of the scene, or as a file of another program says.
#include <cmath>

#include "render/image/image_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/shot.h"
#include "tools/setup/camera_framing.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const Box box(Vector3d(-1, 0, -1), Vector3d(1, 2, 1));

/// A camera that goes to the right by 1.2 m a second and rises, rolled by 10 degrees.
std::string usda_camera() {
  const double c = std::cos(0.1745329252), s = std::sin(0.1745329252);
  const auto sample = [&](int frame) {
    const double x = 0.02 * (frame - 1), y = 0.5 + 0.01 * (frame - 1);
    return std::to_string(frame) + ": ((" + std::to_string(c) + ", " + std::to_string(s) + ", 0, 0), (" +
           std::to_string(-s) + ", " + std::to_string(c) + ", 0, 0), (0, 0, 1, 0), (" + std::to_string(x) + ", " +
           std::to_string(y) + ", 3, 1)),\n";
  };
  return "#usda 1.0\n(\n metersPerUnit = 1\n startTimeCode = 1\n timeCodesPerSecond = 60\n upAxis = \"Y\"\n)\n"
         "def Camera \"shot\"\n{\n float focalLength = 40\n float verticalAperture = 24\n"
         " matrix4d xformOp:transform.timeSamples = {\n" +
         sample(1) + sample(11) + " }\n uniform token[] xformOpOrder = [\"xformOp:transform\"]\n}\n";
}

Words run_words(const fs::path& scene, const fs::path& folder, const Words& more) {
  return Words{"run", scene.string(), "-o", folder.string(), "--set", "clip.frames=6", "--set", "render.layers=all"} +
         more;
}

Image layer_of(const fs::path& exr, const std::string& name) {
  for (const Layer& layer : read_exr(exr))
    if (layer.name == name) return layer.image;
  return {};
}

}  // namespace

TEST_CASE("camera and lights follow their keys") {
  const Scene scene =
      load_scene("figure", {parse_override("camera.position={ keys = [[0, [0, 1, 5]], [1, [2, 1, 5]]] }"),
                            parse_override("camera.target=[0, 1, 0]"),
                            parse_override("camera.vertical_fov={ keys = [[0, 40], [2, 20]] }"),
                            parse_override("camera.focus_distance={ keys = [[0, \"1 m\"], [1, \"3 m\"]] }")});
  CHECK(scene.camera.moves());
  const Camera half = frame_camera(scene.camera, box, 1.5, 0.5);
  CHECK((half.position - Vector3f(1, 1, 5)).norm() < 1e-6f);
  CHECK(half.vertical_fov_degrees == Approx(35));
  CHECK(half.focus_distance == Approx(2));
  CHECK(frame_camera(scene.camera, box, 1.5).vertical_fov_degrees == Approx(40));
  CHECK_FALSE(load_scene("figure").camera.moves());

  // a zoom does not move a camera that frames the motion by itself
  const Scene zoom = load_scene("figure", {parse_override("camera.vertical_fov={ keys = [[0, 40], [2, 20]] }")});
  if (!zoom.camera.position)
    CHECK(frame_camera(zoom.camera, box, 1.5, 0).position == frame_camera(zoom.camera, box, 1.5, 2).position);

  LightDescription light;
  light.position.times = {0, 1};
  light.position.values = {Vector3d(0, 4, 0), Vector3d(4, 4, 0)};
  light.power.times = {0, 1};
  light.power.values = {100, 300};
  const AreaLight later = area_light(light, 0.5);
  CHECK((later.corner + 0.5f * (later.edge_u + later.edge_v) - Vector3f(2, 4, 0)).norm() < 1e-5f);
  CHECK(later.radiance.x() == Approx(2 * area_light(light, 0).radiance.x()));
}

TEST_CASE("what a moving camera sees moves against it, the same for any split of the work") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene(R"(shutter = 0.5
[camera]
position = { keys = [[0, [0, 0.6, 3]], [0.1, [0.3, 0.6, 3]]] }
target = { keys = [[0, [0, 0.4, 0]], [0.1, [0.3, 0.4, 0]]] }
[light.lamp]
position = [1, 3, 1]
power = { keys = [[0, 50], [0.1, 100]] }
)"));
  const Words still{"--set", "clip.gravity=[0, 0, 0]", "--set", "obstacle.ground.visible=false", "--resume"};
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", still)) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "single", still + Words{"--frames", "3"})) == 0);
  for (const char* file : {"0003.png", "0003.exr"})
    CHECK((file_text(folder / "single/frames" / file) == file_text(folder / "whole/frames" / file)));
  CHECK((file_text(folder / "whole/frames/0003.png") != file_text(folder / "whole/frames/0004.png")));
  // 0.05 m a frame to the right at about 3 m, 18 px to 2 m tan(35 / 2)
  const Image vector = layer_of(folder / "whole/frames/0003.exr", "Vector");
  const float* middle = vector.pixel(16, 9);
  const double expected = 0.05 / 2.8 * 9 / std::tan(17.5 * 3.14159265 / 180);
  CHECK(double(middle[0]) == Approx(expected).epsilon(0.05));
  CHECK(double(middle[2]) == Approx(expected).epsilon(0.05));
  CHECK(std::abs(middle[1]) < 0.02f);
}

TEST_CASE("pictures taken by a file's camera have every point where it sees it, within a tenth of a pixel") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene(""));
  make_file(folder / "shot.usda", usda_camera());
  const Words words{"--set", "camera.file=" + (folder / "shot.usda").string(), "--set", "render.size=64x36"};
  REQUIRE(exit_code_of(run_words(scene, folder / "run", words)) == 0);
  for (const int frame : {1, 4}) {
    const fs::path exr = folder / "run/frames" / ("000" + std::to_string(frame) + ".exr");
    const Image position = layer_of(exr, "P"), depth = layer_of(exr, "Z");
    const double c = std::cos(0.1745329252), s = std::sin(0.1745329252), pixel = 2 * 12.0 / 40 / 36;
    double worst = 0;
    int seen = 0;
    for (int y = 0; y < 36; ++y)
      for (int x = 0; x < 64; ++x) {
        if (*depth.pixel(x, y) > 1e9f) continue;
        ++seen;
        const float* p = position.pixel(x, y);
        const double right = double(p[0]) - 0.02 * (frame - 1), up = double(p[1]) - 0.5 - 0.01 * (frame - 1);
        const double away = 3 - double(p[2]);
        worst = std::max(worst, std::abs((c * right + s * up) / away / pixel + 32 - (x + 0.5)));
        worst = std::max(worst, std::abs(18 - (-s * right + c * up) / away / pixel - (y + 0.5)));
        CHECK(double(*depth.pixel(x, y)) == Approx(away).epsilon(1e-5));
      }
    CHECK(seen > 300);
    CHECK(worst < 0.01);
  }
  // the resolved scene makes the same picture
  REQUIRE(exit_code_of(
              {"run", (folder / "run/scene.toml").string(), "-o", (folder / "again").string(), "--frames", "4"}) == 0);
  CHECK((file_text(folder / "again/frames/0004.exr") == file_text(folder / "run/frames/0004.exr")));
}

TEST_CASE("a camera that umax has exported takes the same picture") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene(R"([camera]
position = [1, 0.8, 2]
target = [0, 0.3, 0]
)"));
  REQUIRE(exit_code_of(run_words(scene, folder / "run", {"--frames", "2"})) == 0);
  for (const std::string format : {"usd", "gltf"}) {
    REQUIRE(exit_code_of({"export", (folder / "run").string(), "--format", format, "--frames", "1-2"}) == 0);
    const std::string file = format == "usd" ? "scene.usda" : "block.gltf";
    REQUIRE(exit_code_of(
                run_words(scene, folder / format,
                          {"--frames", "2", "--set", "camera.file=" + (folder / "run/export" / file).string()})) == 0);
    const Image ours = layer_of(folder / "run/frames/0002.exr", "P"),
                theirs = layer_of(folder / format / "frames/0002.exr", "P");
    double worst = 0;
    for (std::size_t i = 0; i < ours.values.size(); ++i)
      worst = std::max(worst, std::abs(double(ours.values[i] - theirs.values[i])));
    CHECK(worst < 2e-3);  // of pixels that are 7 cm on what they show
  }
}

TEST_CASE("camera files that do not fit are told with their name and the remedy") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene(""));
  make_file(folder / "none.usda", "#usda 1.0\ndef Xform \"a\" { }\n");
  make_file(folder / "shot.usda", usda_camera());
  const auto refused = [&](const Words& more, int code, const std::string& text) {
    const ProcessResult result = umax_program(run_words(scene, folder / "bad", more));
    INFO(result.messages);
    CHECK(result.exit_code == code);
    CHECK(result.messages.find(text) != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "bad/frames"));
  };
  const auto file = [&](const char* name) { return "camera.file=" + (folder / name).string(); };
  refused({"--set", file("absent.glb")}, 66, "absent.glb");
  refused({"--set", file("none.usda")}, 65, "has no camera");
  refused({"--set", file("shot.usda"), "--set", "camera.name=\"Bob\""}, 65, "shot");
  refused({"--set", "camera.position={ keys = [[0, [0, 0, 0]], [1, [0, 1, 0]]] }", "--set", "camera.target=[0, 1, 0]"},
          65, "is also the camera's target");
}
