// Motion blur of a run: which states a frame needs, and the same pictures for any split of the work.
#include "tools/pictures/exposure.h"

#include <algorithm>

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/motion_blur.h"
#include "tools/pictures/traced_picture.h"
#include "tools/run/render_frames.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

RenderDescription with_shutter(double shutter, double position = 0.5) {
  RenderDescription render;
  render.denoise = NoiseFilter::spatial;
  render.shutter = shutter;
  render.shutter_position = position;
  return render;
}

/// A block in flight before a camera that stands where it is told to. The ground is not drawn: how far it reaches
/// depends on the states that are there.
std::string flying_block() {
  return block_scene(R"(shutter = 1
[camera]
position = [0, 0.6, 3]
target = [0, 0.4, 0]
)");
}

Words run_words(const fs::path& scene, const fs::path& folder, const Words& more) {
  Words words{"run",
              scene.string(),
              "-o",
              folder.string(),
              "--resume",
              "--set",
              "clip.frames=6",
              "--set",
              "body.block.velocity=[3, 1, 0]",
              "--set",
              "obstacle.ground.visible=false"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace

TEST_CASE("the shutter is open about its frame's own time, within the clip") {
  CHECK(exposure_of(with_shutter(0), 5, 9) == Exposure{5, 5});
  CHECK(exposure_of(with_shutter(0.5), 5, 9) == Exposure{4.75, 5.25});
  CHECK(exposure_of(with_shutter(1, 0), 5, 9) == Exposure{5, 6});
  CHECK(exposure_of(with_shutter(1, 1), 5, 9) == Exposure{4, 5});
  CHECK(exposure_of(with_shutter(2), 5, 9) == Exposure{4, 6});
  // one-sided at the ends
  CHECK(exposure_of(with_shutter(0.5), 1, 9) == Exposure{1, 1.25});
  CHECK(exposure_of(with_shutter(0.5), 9, 9) == Exposure{8.75, 9});
  CHECK(exposure_of(with_shutter(0.5), 1, 1) == Exposure{1, 1});
  // what is not to be blurred
  RenderDescription render = with_shutter(0.5);
  render.heatmap = Heatmap::energy;
  CHECK(exposure_of(render, 5, 9) == Exposure{5, 5});
  render = with_shutter(0.5);
  render.engine = RenderEngine::osmesa;
  CHECK(exposure_of(render, 5, 9) == Exposure{5, 5});

  CHECK(Exposure{4.75, 5.25}.first_state() == 4);
  CHECK(Exposure{4.75, 5.25}.last_state() == 6);
  CHECK(Exposure{4, 5}.last_state() == 5);
  CHECK(last_frame_with(with_shutter(0.5), 5, 9) == 4);
  CHECK(last_frame_with(with_shutter(0.5), 9, 9) == 9);
  CHECK(last_frame_with(with_shutter(0), 5, 9) == 5);
  CHECK(last_frame_with(with_shutter(0.5), 1, 9) == 0);
}

TEST_CASE("blurred pictures are the same bytes for the whole clip, for single frames and for a clip that grew") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, flying_block());
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", {})) == 0);
  const auto whole = pictures_of(folder / "whole");
  REQUIRE(whole.size() == 6);

  // a frame alone is simulated to its neighbour
  REQUIRE(exit_code_of(run_words(scene, folder / "single", {"--frames", "3"})) == 0);
  CHECK(states_of(folder / "single").size() == 4);
  CHECK(pictures_of(folder / "single") == std::map<std::string, std::string>{*whole.find("0003.png")});
  REQUIRE(exit_code_of(run_words(scene, folder / "single", {"--frames", "5-6"})) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "single", {"--frames", "1,2,4"})) == 0);
  CHECK(pictures_of(folder / "single") == whole);

  // the last picture of a shorter clip is cut off: it is made anew, and no other
  REQUIRE(exit_code_of(run_words(scene, folder / "grown", {"--set", "clip.frames=4"})) == 0);
  const auto shorter = pictures_of(folder / "grown");
  REQUIRE(shorter.size() == 4);
  CHECK(shorter.at("0003.png") == whole.at("0003.png"));
  CHECK(shorter.at("0004.png") != whole.at("0004.png"));
  const auto written = fs::last_write_time(folder / "grown/frames/0003.png");
  REQUIRE(exit_code_of(run_words(scene, folder / "grown", {})) == 0);
  CHECK(pictures_of(folder / "grown") == whole);
  CHECK(fs::last_write_time(folder / "grown/frames/0003.png") == written);
}

TEST_CASE("render draws the frames whose neighbours are there, and no others") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, flying_block());
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (folder / "run").string(), "--frames", "1-4"}) == 0);
  CHECK(states_of(folder / "run").size() == 5);  // with the neighbour
  REQUIRE(exit_code_of({"render", (folder / "run").string()}) == 0);
  CHECK(pictures_of(folder / "run").size() == 4);
  // frame 5 waits for state 6
  const ProcessResult missing = umax_program({"render", (folder / "run").string(), "--resume", "--frames", "5"});
  CHECK(missing.exit_code == 2);
  CHECK(pictures_of(folder / "run").size() == 4);
}

TEST_CASE("pixels that edges sweep over in a frame of few samples get as many paths as those that they stand on") {
  const Scene scene = load_scene("press", {parse_override("render.shutter=1"), parse_override("clip.frames=9"),
                                           parse_override("render.size=[96, 54]"), parse_override("render.samples=2")});
  const Simulation simulation = set_up(scene);
  State now = rest_state(simulation.model), after = now;
  after.time = 1 / scene.clip.fps;
  after.positions.col(0).array() += 0.3;
  const Stage stage = make_stage(simulation, box_of(simulation, now.positions));
  const RenderScene sharp = make_shot(simulation, stage, now, Camera());
  RenderScene blurred = sharp;
  add_motion(simulation, stage, {now, after}, exposure_of(scene.render, 1, 9), 1, blurred);
  const auto pixels_of_many = [&](const RenderScene& shot) {
    const std::vector<float> samples = trace_shot(shot, scene.render, 1).image.samples.values;
    return std::count(samples.begin(), samples.end(), *std::max_element(samples.begin(), samples.end()));
  };
  const auto on_edges = pixels_of_many(sharp), swept = pixels_of_many(blurred);
  CAPTURE(on_edges, swept);
  CHECK(on_edges > 100);
  CHECK(double(swept) > 1.2 * double(on_edges));
}

TEST_CASE("what stands still is given no motion, and what moves is where its states and tracks say") {
  const Scene scene = load_scene("press", {parse_override("render.shutter=1"), parse_override("clip.frames=9")});
  const Simulation simulation = set_up(scene);
  State before = rest_state(simulation.model), now = before, after = before;
  const double step = 1 / scene.clip.fps;
  before.time = 3 * step, now.time = 4 * step, after.time = 5 * step;
  after.positions.col(1).array() -= 0.01;
  const Exposure exposure = exposure_of(scene.render, 5, 9);
  const Stage stage = make_stage(simulation, box_of(simulation, now.positions));
  RenderScene shot = make_shot(simulation, stage, now, Camera());
  add_motion(simulation, stage, {before, now, after}, exposure, 5, shot);

  const SurfaceMotion& ball = shot.objects[0].motion;
  REQUIRE(ball.instants.size() == 3);
  CHECK(ball.first == Approx(-0.5));
  CHECK(ball.last == Approx(1.5));
  CHECK((ball.instants[1]->positions - shot.objects[0].mesh->positions).norm() == 0);
  CHECK((ball.instants[2]->positions - shot.objects[0].mesh->positions).col(1).maxCoeff() == Approx(-0.01));

  int moving = 0;
  for (std::size_t i = 1; i < shot.objects.size(); ++i) {
    const SurfaceMotion& motion = shot.objects[i].motion;
    if (motion.instants.empty()) continue;
    ++moving;
    const Obstacle& obstacle = simulation.model.obstacles[i - 1];
    const Points way = motion.instants.back()->positions - motion.instants.front()->positions;
    const Vector3d expected = pose_at(obstacle, 4.5 * step).translation - pose_at(obstacle, 3.5 * step).translation;
    CHECK((way.rowwise() - expected.transpose()).cwiseAbs().maxCoeff() < 1e-12);
  }
  CHECK(moving == 1);                                    // the plate
  CHECK(shot.objects.size() > std::size_t(moving) + 1);  // the ground

  RenderScene still = make_shot(simulation, stage, now, Camera());
  add_motion(simulation, stage, {now, now, now}, exposure, 5, still);
  CHECK(still.objects[0].motion.instants.empty());
}

TEST_CASE("the camera of a turntable blurs all around the circle") {
  const Scene scene = load_scene("turntable", {parse_override("render.shutter=0.5"), parse_override("clip.frames=12")});
  const Simulation simulation = set_up(scene);
  const RunPictures pictures = turntable_of(simulation, rest_state(simulation.model), {1, 7});
  const RenderScene first = pictures.list.shot(1);
  REQUIRE(first.camera_path.size() >= 3);
  const auto angle = [](const Vector3f& a, const Vector3f& b) {
    return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0f, 1.0f)) * 180 / 3.14159265f;
  };
  const auto from_middle = [&](const Camera& camera) {
    return Vector3f((camera.position - camera.target).cwiseProduct(Vector3f(1, 0, 1)));
  };
  CHECK(angle(from_middle(first.camera_path.front()), from_middle(first.camera_path.back())) ==
        Approx(15).margin(0.1));  // half a frame of 30 degrees
  CHECK(angle(from_middle(first.camera_path[first.camera_path.size() / 2]), from_middle(first.camera)) < 0.1f);
}
