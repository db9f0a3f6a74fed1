// The noise filter that looks at the frames around one: which states it needs, and the same pictures for any split of the
// work.
#include <fmt/format.h>

#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/exposure.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

RenderDescription with_filter(NoiseFilter filter) {
  RenderDescription render;
  render.denoise = filter;
  return render;
}

/// A block that flies over an obstacle before a camera that stands where it is told to. The ground is not drawn: how far it
/// reaches depends on the states that are there.
fs::path flying_block(const TemporaryFolder& folder) {
  return write_scene(folder, block_scene(R"([camera]
position = [0, 0.6, 3]
target = [0, 0.4, 0]
[light.key]
position = [1, 3, 2]
[obstacle.table]
shape = "box"
size = [3, 0.1, 1]
position = [0, -0.06, -1]
)"));
}

Words run_words(const fs::path& scene, const fs::path& folder, int frames, const Words& more) {
  return Words{"run",
               scene.string(),
               "-o",
               folder.string(),
               "--resume",
               "--set",
               fmt::format("clip.frames={}", frames),
               "--set",
               "body.block.velocity=[2, 1, 0]",
               "--set",
               "obstacle.ground.visible=false",
               "--set",
               "render.denoise=temporal",
               "--set",
               "render.samples=2"} +
         more;
}

constexpr int clip_frames = 16;

}  // namespace

TEST_CASE("a frame's filter looks two frames to either side, within the clip, where it is asked to") {
  const RenderDescription temporal = with_filter(NoiseFilter::temporal);
  const auto window = [](const RenderDescription& render, int frame) {
    const FrameWindow frames = frames_for(render, frame, 9);
    return std::pair(frames.first, frames.last);
  };
  CHECK(window(temporal, 5) == std::pair(3, 7));
  CHECK(window(temporal, 1) == std::pair(1, 3));
  CHECK(window(temporal, 2) == std::pair(1, 4));
  CHECK(window(temporal, 9) == std::pair(7, 9));
  CHECK(window(with_filter(NoiseFilter::spatial), 5) == std::pair(5, 5));
  CHECK(window(with_filter(NoiseFilter::none), 5) == std::pair(5, 5));
  RenderDescription render = temporal;
  render.preview = true;
  CHECK(window(render, 5) == std::pair(5, 5));
  render = temporal;
  render.transparent = true;
  CHECK(window(render, 5) == std::pair(5, 5));
  render = temporal;
  render.engine = RenderEngine::osmesa;
  CHECK(window(render, 5) == std::pair(5, 5));

  CHECK(states_for(temporal, 5, 9) == StateWindow{3, 7});
  CHECK(states_of_shot(temporal, 5, 9) == StateWindow{5, 5});
  // with the exposure of the outermost frames; their motion vectors are nobody's
  render = temporal;
  render.shutter = 1;
  CHECK(states_for(render, 5, 9) == StateWindow{2, 8});
  CHECK(states_for(render, 8, 9) == StateWindow{5, 9});
  render = temporal;
  render.layers = {PictureLayer::vector};
  CHECK(states_for(render, 5, 9) == StateWindow{3, 7});
  CHECK(last_frame_with(temporal, 5, 9) == 3);
  CHECK(last_frame_with(temporal, 9, 9) == 9);
}

TEST_CASE("filtered pictures are the same bytes for the whole clip, single frames, chunks and any number of threads") {
  const TemporaryFolder folder;
  const fs::path scene = flying_block(folder);
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", clip_frames, {"--threads", "1"})) == 0);
  const auto whole = pictures_of(folder / "whole");
  REQUIRE(whole.size() == clip_frames);

  // a frame alone is simulated two frames on
  REQUIRE(exit_code_of(run_words(scene, folder / "single", clip_frames, {"--frames", "6", "--threads", "2"})) == 0);
  CHECK(states_of(folder / "single").size() == 8);
  CHECK(pictures_of(folder / "single") == std::map<std::string, std::string>{*whole.find("0006.png")});
  REQUIRE(exit_code_of(run_words(scene, folder / "single", clip_frames, {"--frames", "16"})) == 0);
  CHECK(pictures_of(folder / "single").at("0016.png") == whole.at("0016.png"));

  for (const char* chunk : {"1-7", "8-14", "15-16"})
    REQUIRE(exit_code_of(run_words(scene, folder / "chunks", clip_frames, {"--frames", chunk})) == 0);
  CHECK(pictures_of(folder / "chunks") == whole);

  // from states alone, every other frame first, into another folder
  const auto render = [&](const char* frames) {
    return exit_code_of(
        {"render", (folder / "whole").string(), "-o", (folder / "again").string(), "--resume", "--frames", frames});
  };
  REQUIRE(render("2-16x2") == 0);
  REQUIRE(render("1-16") == 0);
  CHECK(pictures_of(folder / "again") == whole);

  // it is not the filter that looks at one frame alone
  REQUIRE(exit_code_of({"render", (folder / "whole").string(), "-o", (folder / "spatial").string(), "--set",
                        "render.denoise=spatial", "--frames", "6"}) == 0);
  CHECK(pictures_of(folder / "spatial").at("0006.png") != whole.at("0006.png"));
}

TEST_CASE("filtered pictures are the same bytes after the program was killed and went on") {
  const TemporaryFolder folder;
  const fs::path scene = flying_block(folder);
  const Words more{"--set", "render.size=[128, 72]"};
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", clip_frames, more)) == 0);
  int kills = 0, code = -1;
  for (double seconds = 0.1; code != 0 && kills < 60; seconds *= 1.2) {
    const Words words = run_words(scene, folder / "killed", clip_frames, more);
    code = run_process(Words{"timeout", "-s", "KILL", fmt::format("{:.3f}", seconds), UMAX_PROGRAM} + words).exit_code;
    kills += code != 0;
  }
  CHECK(code == 0);
  CHECK(kills > 0);
  CHECK(pictures_of(folder / "killed") == pictures_of(folder / "whole"));
}

TEST_CASE("a clip that grows draws its last two pictures again, and no others") {
  const TemporaryFolder folder;
  const fs::path scene = flying_block(folder);
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", clip_frames, {})) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "grown", 8, {})) == 0);
  const auto whole = pictures_of(folder / "whole"), shorter = pictures_of(folder / "grown");
  CHECK(shorter.at("0006.png") == whole.at("0006.png"));
  CHECK(shorter.at("0007.png") != whole.at("0007.png"));
  CHECK(shorter.at("0008.png") != whole.at("0008.png"));
  const auto written = fs::last_write_time(folder / "grown/frames/0006.png");
  REQUIRE(exit_code_of(run_words(scene, folder / "grown", clip_frames, {})) == 0);
  CHECK(pictures_of(folder / "grown") == whole);
  CHECK(fs::last_write_time(folder / "grown/frames/0006.png") == written);
}

TEST_CASE("a turntable's filter looks across the end of the circle, whatever part of it is drawn") {
  const TemporaryFolder folder;
  const fs::path scene = flying_block(folder);
  const auto turn = [&](const char* name, const Words& more) {
    return exit_code_of(Words{"turntable", scene.string(), "-o", (folder / name).string(), "--resume", "--set",
                              "render.denoise=temporal", "--set", "clip.frames=7"} +
                        more);
  };
  REQUIRE(turn("whole", {}) == 0);
  REQUIRE(turn("part", {"--frames", "7"}) == 0);
  REQUIRE(turn("part", {"--frames", "1,4"}) == 0);
  const auto whole = pictures_of(folder / "whole");
  CHECK(whole.size() == 7);
  for (const auto& [name, bytes] : pictures_of(folder / "part")) CHECK(bytes == whole.at(name));
}

TEST_CASE("a frame with motion vectors and filter is drawn where their states are, of neighbours that have none") {
  const TemporaryFolder folder;
  const fs::path scene = flying_block(folder);
  const Words layered{"--set", "render.layers=[\"vector\", \"noise\"]"};
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", 8, layered)) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "single", 8, layered + Words{"--frames", "4"})) == 0);
  CHECK(states_of(folder / "single").size() == 6);
  const auto whole = pictures_of(folder / "whole"), single = pictures_of(folder / "single");
  CHECK(single.size() == 2);
  CHECK(single.at("0004.exr") == whole.at("0004.exr"));
  CHECK(single.at("0004.png") == whole.at("0004.png"));
}
