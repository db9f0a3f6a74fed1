// Several instants or runs in one picture.
#include "tools/pictures/strip.h"

#include <cmath>
#include <numbers>

#include "render/image/image_io.h"
#include "render/scene/camera.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/shot.h"

using namespace umax;

namespace {

std::shared_ptr<const Simulation> block(const std::vector<std::string>& settings = {}) {
  std::vector<Override> overrides;
  for (const std::string& setting : settings) overrides.push_back(parse_override(setting));
  return std::make_shared<const Simulation>(
      set_up(parse_scene({.text = block_scene("[light.key]\nposition = [2, 3, 3]\n[obstacle.post]\nshape = \"box\"\n"
                                              "size = [0.1, 0.1, 0.1]\nposition = [0.3, 0, 0]\n")},
                         overrides)));
}

/// Low and high end of a mesh along a direction.
std::pair<double, double> ends(const TriangleMesh& mesh, const Vector3d& direction) {
  const VectorXd along = mesh.positions * direction;
  return {along.minCoeff(), along.maxCoeff()};
}

}  // namespace

TEST_CASE("things in a strip stand side by side on one ground, all in the picture") {
  const auto soft = block(), moved = block({"body.block.position=[9, 0.24, 4]", "probe.middle.point=[9, 0.24, 4]"});
  const double aspect = 3;
  std::vector<StripItem> items;
  for (const auto& simulation : {soft, moved, soft}) items.push_back({simulation, rest_state(simulation->model), {}});
  items[1].label = "the one in the middle";
  const RenderScene strip = make_strip(items, aspect);

  // the ground once; block and post three times
  REQUIRE(strip.objects.size() == 1 + 3 * 2);
  CHECK(strip.objects[0].name == "obstacle.ground");
  const Vector3d back = (strip.camera.position - strip.camera.target).cast<double>().normalized();
  const Vector3d right = Vector3d::UnitY().cross(back).normalized();
  double previous = -1e9;
  const CameraView view = make_camera_view(strip.camera, 300, 100);
  for (const std::size_t at : {1, 3, 5}) {
    CHECK(strip.objects[at].name == "block");
    const auto [low, high] = ends(*strip.objects[at].mesh, right);
    CHECK(low > previous);
    previous = high;
    for (const auto& point : strip.objects[at].mesh->positions.rowwise()) {
      const Vector3d from = point.transpose() - view.position.cast<double>();
      const double depth = from.dot(view.forward.cast<double>());
      const double half = std::tan(double(strip.camera.vertical_fov_degrees) * std::numbers::pi / 360);
      CHECK(std::abs(from.dot(view.up.cast<double>())) < depth * half);
      CHECK(std::abs(from.dot(view.right.cast<double>())) < depth * half * aspect);
    }
  }
  // the same block from another place is the same picture but for its own place
  CHECK(ends(*strip.objects[3].mesh, Vector3d::UnitY()).first ==
        Approx(ends(*strip.objects[1].mesh, Vector3d::UnitY()).first));
  REQUIRE(strip.captions.size() == 1);
  CHECK(strip.captions[0].text == "the one in the middle");
  CHECK(strip.captions[0].x == Approx(0.5f).margin(0.03));
  // three dimmed lamps; far apart they would be undimmed, in one place a third each
  REQUIRE(strip.lights.size() == 3);
  const float alone = area_light(soft->scene.lights[0]).radiance[0];
  CHECK(strip.lights[0].radiance[0] < alone);
  CHECK(strip.lights[0].radiance[0] > alone / 3);
}

TEST_CASE("a strip of one thing is lit as the thing alone") {
  const auto soft = block();
  const RenderScene strip = make_strip({{soft, rest_state(soft->model), {}}}, 1);
  REQUIRE(strip.lights.size() == 1);
  CHECK(strip.lights[0].radiance.isApprox(area_light(soft->scene.lights[0]).radiance));
}

TEST_CASE("a strip's heat map has one bar for all its things") {
  const auto soft = block({"render.heatmap=stretch"});
  State stretched = rest_state(soft->model);
  stretched.positions.col(0) *= 1.3;
  const RenderScene strip =
      make_strip({{soft, rest_state(soft->model), {}},
                  {block({"body.block.limit.kind=none", "render.heatmap=stretch"}), stretched, {}}},
                 2);
  REQUIRE(strip.legend.has_value());
  CHECK_FALSE(strip.legend->ends_at_limit);  // one of them has none
  CHECK(strip.legend->high >= 25);
}

TEST_CASE("umax strip draws runs and frames, and refuses what is not there") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), a = (folder / "a").string(),
                    b = (folder / "b").string(), strip_png = (folder / "strip.png").string();
  const Words short_clip{"--set", "clip.frames=3"};
  REQUIRE(exit_code_of(Words{"simulate", scene, "-o", a} + short_clip) == 0);
  REQUIRE(exit_code_of(Words{"simulate", scene, "-o", b, "--set", "body.block.limit.stretch=2%"} + short_clip) == 0);
  const Words strip{"strip", a, b, "--frames", "1,3", "--size", "120x40", "-o", strip_png};
  const Words labels{"--label", "a1", "--label", "a3", "--label", "b1", "--label", "b3"};
  const std::string engine = GENERATE("embree", "osmesa");
  const ProcessResult result =
      umax_program(strip + labels + Words{"--engine", engine, "--set", "render.heatmap=stretch"});
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  const Image8 picture = read_png8(strip_png);
  CHECK(picture.width == 120);
  CHECK(picture.height == 40);

  CHECK(exit_code_of(strip + labels) == 73);
  CHECK(exit_code_of(strip + Words{"--label", "one", "--overwrite"}) == 2);
  CHECK(exit_code_of({"strip"}) == 2);
  CHECK(exit_code_of({"strip", a, "--frames", "4", "-o", (folder / "x.png").string()}) == 66);
  CHECK(exit_code_of({"strip", folder.path().string(), "-o", (folder / "x.png").string()}) == 66);
  CHECK_FALSE(std::filesystem::exists(folder / "x.png"));
}
