// Layers and transparency of a run's pictures: what is asked for is there, the same for any split of the work, and what
// cannot be had is said.
#include <set>

#include "render/image/image_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/exposure.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

fs::path layered_scene(const TemporaryFolder& folder) {
  return write_scene(folder, block_scene(R"([camera]
position = [0, 0.6, 3]
target = [0, 0.4, 0]
)"));
}

Words run_words(const fs::path& scene, const fs::path& folder, const Words& more) {
  return Words{"run",   scene.string(),  "-o",    folder.string(),
               "--set", "clip.frames=6", "--set", "body.block.velocity=[3, 1, 0]"} +
         more;
}

const Words all_layers{"--set", "render.layers=all"};

Image layer_of(const fs::path& exr, const std::string& name) {
  for (const Layer& layer : read_exr(exr))
    if (layer.name == name) return layer.image;
  return {};
}

std::set<std::string> layer_names(const fs::path& exr) {
  std::set<std::string> names;
  for (const Layer& layer : read_exr(exr)) names.insert(layer.name);
  return names;
}

float largest_of(const Image& image, int channel) {
  float largest = 0;
  for (std::size_t i = std::size_t(channel); i < image.values.size(); i += std::size_t(image.channels))
    largest = std::max(largest, std::abs(image.values[i]));
  return largest;
}

}  // namespace

TEST_CASE("motion vectors need the states beside a frame") {
  RenderDescription render;
  render.denoise = NoiseFilter::spatial;
  CHECK(states_for(render, 5, 9) == StateWindow{5, 5});
  render.layers = {PictureLayer::vector};
  CHECK(states_for(render, 5, 9) == StateWindow{4, 6});
  CHECK(states_for(render, 1, 9) == StateWindow{1, 2});
  CHECK(states_for(render, 9, 9) == StateWindow{8, 9});
  CHECK(states_for(render, 1, 1) == StateWindow{1, 1});
  CHECK(last_frame_with(render, 5, 9) == 4);
  CHECK(last_frame_with(render, 9, 9) == 9);
}

TEST_CASE("layers are those that are asked for, and pictures the same with and without them") {
  const TemporaryFolder folder;
  const fs::path scene = layered_scene(folder);
  REQUIRE(exit_code_of(run_words(scene, folder / "plain", {})) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "all", all_layers)) == 0);
  CHECK_FALSE(fs::exists(folder / "plain/frames/0003.exr"));
  CHECK((file_text(folder / "all/frames/0003.png") == file_text(folder / "plain/frames/0003.png")));

  const fs::path exr = folder / "all/frames/0003.exr";
  const std::set<std::string> wanted{"",
                                     "Albedo",
                                     "N",
                                     "Z",
                                     "P",
                                     "Vector",
                                     "Object",
                                     "EnergyRatio",
                                     "variance",
                                     "samples",
                                     "CryptoObject00",
                                     "CryptoObject01",
                                     "CryptoObject02",
                                     "CryptoMaterial00",
                                     "CryptoMaterial01",
                                     "CryptoMaterial02"};
  CHECK(layer_names(exr) == wanted);
  CHECK(layer_of(exr, "").channels == 4);
  CHECK(largest_of(layer_of(exr, "Object"), 0) == 2);  // the block and the ground
  const std::string bytes = file_text(exr);
  CHECK(bytes.find("{\"block\":\"") != bytes.npos);
  CHECK(bytes.find("\"obstacle.ground\":\"") != bytes.npos);

  // the first frame comes from nowhere, the last goes nowhere
  const auto speed = [&](const char* frame, int channel) {
    return largest_of(layer_of(folder / "all/frames" / frame, "Vector"), channel);
  };
  CHECK(speed("0001.exr", 0) == 0);
  CHECK(speed("0001.exr", 2) > 0.5f);
  CHECK(speed("0003.exr", 0) > 0.5f);
  CHECK(speed("0006.exr", 0) > 0.5f);
  CHECK(speed("0006.exr", 2) == 0);

  REQUIRE(exit_code_of(run_words(scene, folder / "two", {"--set", "render.layers=[\"vector\", \"depth\"]"})) == 0);
  CHECK(layer_names(folder / "two/frames/0003.exr") == std::set<std::string>{"", "Z", "Vector"});
}

TEST_CASE("layered pictures are the same bytes frame by frame and for a clip that grew") {
  const TemporaryFolder folder;
  const fs::path scene = layered_scene(folder);
  const Words more = all_layers + Words{"--resume", "--set", "obstacle.ground.visible=false"};
  REQUIRE(exit_code_of(run_words(scene, folder / "whole", more)) == 0);
  REQUIRE(exit_code_of(run_words(scene, folder / "single", more + Words{"--frames", "3"})) == 0);
  CHECK(states_of(folder / "single").size() == 4);
  CHECK((file_text(folder / "single/frames/0003.exr") == file_text(folder / "whole/frames/0003.exr")));

  REQUIRE(exit_code_of(run_words(scene, folder / "grown", more + Words{"--set", "clip.frames=4"})) == 0);
  CHECK((file_text(folder / "grown/frames/0004.exr") != file_text(folder / "whole/frames/0004.exr")));
  REQUIRE(exit_code_of(run_words(scene, folder / "grown", more)) == 0);
  for (const char* frame : {"0001.exr", "0003.exr", "0004.exr", "0006.exr"})
    CHECK((file_text(folder / "grown/frames" / frame) == file_text(folder / "whole/frames" / frame)));
}

TEST_CASE("a transparent picture has alpha where the sky was, and its clip is made") {
  const TemporaryFolder folder;
  const fs::path scene = layered_scene(folder);
  const Words clear{"--set", "render.transparent=true", "--set", "obstacle.ground.visible=false"};
  REQUIRE(exit_code_of(run_words(scene, folder / "clear", clear)) == 0);
  const Image8 picture = read_png8(folder / "clear/frames/0002.png");
  REQUIRE(picture.channels == 4);
  CHECK(picture.pixel(0, 0)[3] == 0);
  int solid = 0;
  for (std::size_t i = 3; i < picture.values.size(); i += 4) solid += picture.values[i] == 255 ? 1 : 0;
  CHECK(solid >= 10);
  CHECK(fs::file_size(folder / "clear/clip.mp4") > 500);
  // a bar of colours stands on it, too
  REQUIRE(exit_code_of(run_words(scene, folder / "heat", clear + Words{"--set", "render.heatmap=stretch"})) == 0);
  CHECK(read_png8(folder / "heat/frames/0002.png").channels == 4);
}

TEST_CASE("layers that are not there, and engines that have none, are told with the remedy") {
  const TemporaryFolder folder;
  const fs::path scene = layered_scene(folder);
  const auto refused = [&](const Words& more, const std::string& text) {
    const ProcessResult result = umax_program(run_words(scene, folder / "bad", more));
    INFO(result.messages);
    CHECK(result.exit_code == 65);
    CHECK(result.messages.find(text) != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "bad/frames"));
  };
  refused({"--set", "render.layers=[\"dept\"]"}, "did you mean \"depth\"?");
  refused({"--set", "render.layers=[\"depth\", \"depth\"]"}, "names one twice");
  refused({"--set", "render.layers=3"}, "render.layers");
  refused(all_layers + Words{"--engine", "osmesa"}, "--engine embree");
  refused({"--set", "render.transparent=true", "--engine", "osmesa"}, "--engine embree");
}

TEST_CASE("a ground that catches shadows is seen in them alone") {
  const TemporaryFolder folder;
  const fs::path scene = layered_scene(folder);
  const Words words{"--set", "render.transparent=true", "--set",    "obstacle.ground.shadow_catcher=true",
                    "--set", "render.samples=16",       "--frames", "1"};
  REQUIRE(exit_code_of(run_words(scene, folder / "caught", words)) == 0);
  const Image8 picture = read_png8(folder / "caught/frames/0001.png");
  REQUIRE(picture.channels == 4);
  CHECK(picture.pixel(0, picture.height - 1)[3] < 40);
  CHECK(picture.pixel(picture.width / 2, picture.height / 2)[3] == 255);
  const ProcessResult refused = umax_program(
      run_words(scene, folder / "bad", {"--set", "obstacle.ground.shadow_catcher=true", "--engine", "osmesa"}));
  CHECK(refused.exit_code == 65);
  CHECK(refused.messages.find("--engine embree") != std::string::npos);
}
