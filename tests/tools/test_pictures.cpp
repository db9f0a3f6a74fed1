// From a scene to pictures and a clip, by the built program.
#include "render/image/flip.h"
#include "render/image/image_io.h"
#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tests/tools/program.h"
#include "tools/run/clip.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const Words four_frames{"--set", "clip.frames=4"};

}  // namespace

TEST_CASE("a whole run ends in a clip with as many frames as pictures, by either engine") {
  const TemporaryFolder folder;
  const std::string engine = GENERATE("embree", "osmesa");
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  const ProcessResult result =
      umax_program(Words{"run", scene.string(), "-o", run.string(), "--engine", engine} + four_frames);
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  CHECK(pictures_of(run).size() == 4);
  const ProcessResult count =
      run_process({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                   "stream=nb_read_frames,pix_fmt,codec_name", "-of", "csv=p=0", (run / "clip.mp4").string()});
  CHECK(count.output == "h264,yuv420p,4\n");
  CHECK(!has_half_written_files(run));
}

TEST_CASE("rendering again and with other threads gives the same pictures and clip") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string(), "--threads", "1"} + four_frames) == 0);
  const auto before = pictures_of(run);
  const std::string clip = file_text(run / "clip.mp4");
  CHECK(exit_code_of({"render", run.string()}) == 73);
  REQUIRE(exit_code_of({"render", run.string(), "--overwrite", "--threads", "2"}) == 0);
  CHECK(pictures_of(run) == before);
  CHECK(file_text(run / "clip.mp4") == clip);
  fs::remove(run / "frames/0003.png");
  REQUIRE(exit_code_of({"render", run.string(), "--resume"}) == 0);
  CHECK(pictures_of(run) == before);
}

TEST_CASE("a preview has the light and the shadows of the picture") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run", quick = folder / "quick";
  const Words large{"--set", "render.size=[320, 180]", "--set", "render.samples=64", "--set", "render.denoise=true"};
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string(), "--frames", "8"} + large) == 0);
  REQUIRE(exit_code_of(Words{"render", run.string(), "-o", quick.string(), "--frames", "8", "--quick"} + large) == 0);
  CHECK(file_text(quick / "scene.toml").find("preview = true") != std::string::npos);
  const Image8 picture = read_png8(run / "frames/0008.png"), preview = read_png8(quick / "frames/0008.png");
  CHECK(preview.values != picture.values);
  CHECK(flip(picture, preview).mean < 0.1);
  // two paths a pixel are all that it takes
  const fs::path two = folder / "two";
  REQUIRE(exit_code_of(Words{"render", run.string(), "-o", two.string(), "--frames", "8", "--quick"} + large +
                       Words{"--set", "render.samples=2"}) == 0);
  CHECK(pictures_of(two) == pictures_of(quick));
  // who says how many samples gets them
  REQUIRE(exit_code_of({"render", run.string(), "-o", (folder / "eight").string(), "--frames", "8", "--quick",
                        "--samples", "8"}) == 0);
  CHECK(file_text(folder / "eight/scene.toml").find("preview = true") == std::string::npos);
}

TEST_CASE("compare tells equal pictures from different ones") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string()} + four_frames) == 0);
  REQUIRE(exit_code_of({"render", run.string(), "-o", (folder / "red").string(), "--set",
                        "body.block.look.color=[0.9, 0, 0]"}) == 0);
  const std::string a = (run / "frames/0001.png").string(), b = (folder / "red/frames/0001.png").string();
  CHECK(exit_code_of({"compare", a, a}) == 0);
  CHECK(exit_code_of({"compare", a, b}) == 1);
  CHECK(exit_code_of({"compare", a, b, "--max-flip", "1"}) == 0);
  CHECK(exit_code_of({"compare", run.string(), (folder / "red").string()}) == 1);
  CHECK(exit_code_of({"compare", run.string(), run.string()}) == 0);
  CHECK(exit_code_of({"compare", a, run.string()}) == 2);
  fs::remove(folder / "red/frames/0002.png");
  CHECK(exit_code_of({"compare", run.string(), (folder / "red").string()}) == 66);
}

TEST_CASE("compare takes clips, frame by frame, and shows the worst one on a page") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run", red = folder / "red",
                 page = folder / "page.html";
  fs::create_directory(folder / "temporary");
  setenv("TMPDIR", (folder / "temporary").c_str(), 1);
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string()} + four_frames) == 0);
  REQUIRE(exit_code_of({"render", run.string(), "-o", red.string(), "--set", "body.block.look.color=[0.9, 0, 0]"}) ==
          0);
  const std::string a = (run / "clip.mp4").string(), b = (red / "clip.mp4").string();
  CHECK(exit_code_of({"compare", a, a, "--max-flip", "0"}) == 0);
  CHECK(exit_code_of({"compare", a, b, "--report", page.string()}) == 1);
  const std::string text = file_text(page);
  CHECK(text.find("<svg") != std::string::npos);
  CHECK(text.find("past the threshold of 0.02") != std::string::npos);
  // a clip is what its pictures are, but for what encoding loses
  CHECK(exit_code_of({"compare", run.string(), a, "--max-flip", "0.1"}) == 0);
  CHECK(exit_code_of({"compare", red.string(), a, "--max-flip", "0.02"}) == 1);
  // what cannot be compared
  CHECK(exit_code_of({"compare", a, (run / "frames/0001.png").string()}) == 2);
  REQUIRE(exit_code_of(Words{"render", run.string(), "-o", (folder / "short").string(), "--frames", "1-3"}) == 0);
  CHECK(exit_code_of({"compare", a, (folder / "short/clip.mp4").string()}) == 65);
  make_file(folder / "no.mp4", "no clip");
  CHECK(exit_code_of({"compare", a, (folder / "no.mp4").string()}) == 65);
  CHECK(fs::is_empty(folder / "temporary"));
  unsetenv("TMPDIR");
}

TEST_CASE("pictures of other settings are made anew when a run goes on") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string()} + four_frames) == 0);
  const auto before = pictures_of(run);
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string(), "--resume", "--set", "render.exposure=1"} +
                       four_frames) == 0);
  CHECK(pictures_of(run) != before);
}

TEST_CASE("a turntable needs no states, and goes round a chosen one") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  REQUIRE(exit_code_of(Words{"turntable", scene.string(), "-o", (folder / "scene").string()} + four_frames) == 0);
  CHECK(pictures_of(folder / "scene").size() == 4);
  REQUIRE(exit_code_of(Words{"simulate", scene.string(), "-o", run.string()} + four_frames) == 0);
  REQUIRE(exit_code_of(Words{"turntable", run.string(), "-o", (folder / "still").string(), "--still", "3"} +
                       four_frames) == 0);
  CHECK(pictures_of(folder / "still") != pictures_of(folder / "scene"));
  CHECK(exit_code_of(Words{"turntable", run.string(), "-o", (folder / "none").string(), "--still", "99"} +
                     four_frames) == 66);
}

TEST_CASE("pictures drawn in parts make the clip that they make in one go") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = folder / "whole", parts = folder / "parts";
  const Words set{"--set", "clip.frames=4"};
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", whole.string()} + set) == 0);
  REQUIRE(exit_code_of(Words{"simulate", scene.string(), "-o", parts.string()} + set) == 0);
  CHECK(exit_code_of({"encode", parts.string()}) == 66);
  const auto draw = [&](const std::string& frames) {
    return exit_code_of({"render", parts.string(), "--resume", "--no-clip", "--frames", frames});
  };
  REQUIRE(draw("3-4") == 0);
  CHECK(exit_code_of({"encode", parts.string()}) == 66);
  CHECK(!fs::exists(parts / "clip.mp4"));
  REQUIRE(draw("1-2") == 0);
  CHECK(!fs::exists(parts / "clip.mp4"));
  REQUIRE(exit_code_of({"encode", parts.string()}) == 0);
  CHECK(file_text(parts / "clip.mp4") == file_text(whole / "clip.mp4"));
  REQUIRE(exit_code_of({"encode", parts.string(), "--frames", "2-3"}) == 0);
  CHECK(file_text(parts / "clip.mp4") != file_text(whole / "clip.mp4"));
  CHECK(exit_code_of({"encode", (folder / "nothing").string()}) == 66);
  make_file(parts / "frames/0002.png", "no picture");
  CHECK(exit_code_of({"encode", parts.string()}) == 65);
  // without a clip a picture may have any size
  CHECK(exit_code_of(Words{"run", scene.string(), "-o", (folder / "odd").string(), "--no-clip", "--size", "33x19"} +
                     set) == 0);
  CHECK(!fs::exists(folder / "odd/clip.mp4"));
}

TEST_CASE("damaged pictures are not encoded") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), run = folder / "run";
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string()} + four_frames) == 0);
  const fs::path picture = run / "frames/0002.png";
  const std::string bytes = file_text(picture);
  CHECK(error_code_of([&] { check_png(picture, 32, 18); }) == 0);
  CHECK(error_code_of([&] { check_png(picture, 64, 18); }) == 65);
  make_file(picture, bytes.substr(0, bytes.size() / 2));
  CHECK(error_code_of([&] { check_png(picture, 32, 18); }) == 65);
  std::string damaged = bytes;
  damaged[damaged.size() / 2] = char(damaged[damaged.size() / 2] ^ 1);
  make_file(picture, damaged);
  CHECK(error_code_of([&] {
          encode_clip(folder / "clip.mp4", {run / "frames/0001.png", picture}, {.fps = 60, .width = 32, .height = 18});
        }) == 65);
  CHECK(!fs::exists(folder / "clip.mp4"));
  CHECK(!has_half_written_files(folder.path()));
}
