// Variants side by side: what --vary means, and what umax tune leaves behind when all goes well and when not.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tests/tools/program.h"
#include "tools/trials/snippet.h"
#include "tools/trials/variants.h"
#include "tools/trials/workers.h"
#include "tools/tune/measures.h"
#include "tools/tune/preview.h"
#include "tools/tune/tune_page.h"

#include "render/image/image_io.h"
#include "scenes/scene_file.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

Words names_of(const Words& variations) {
  std::vector<Variation> parsed;
  for (const std::string& text : variations) parsed.push_back(parse_variation(text));
  Words names;
  for (const SceneVariant& variant : combinations(parsed)) names.push_back(variant.name);
  return names;
}

/// Quick to make: 8 hexes, 6 frames of 32 x 18 pixels.
Words tune_block(const TemporaryFolder& folder, const Words& more = {}) {
  const std::string scene = write_scene(folder, block_scene()).string();
  return Words{"tune", scene, "-o", (folder / "out").string(), "--set", "clip.frames=6"} + more;
}

const Words two_limits{"--vary", "body.block.limit.stretch=5%,10%"};

nlohmann::json record_of(const TemporaryFolder& folder) {
  return nlohmann::json::parse(file_text(folder / "out/tune.json"));
}

std::map<std::string, fs::file_time_type> times_of(const fs::path& folder) {
  std::map<std::string, fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".state" || entry.path().extension() == ".png")
      times[entry.path().string()] = entry.last_write_time();
  return times;
}

}  // namespace

TEST_CASE("a --vary lists values between commas that stand in no bracket and no quote", "[tune]") {
  const Variation plain = parse_variation("body.a.limit.stretch = 5 %, 10 %,20%");
  CHECK(plain.keys == Words{"body.a.limit.stretch"});
  CHECK(plain.values == Words{"5 %", "10 %", "20%"});
  CHECK(parse_variation("body.a.cage.cells=[2,2,2],[4, 4, 4],100").values == Words{"[2,2,2]", "[4, 4, 4]", "100"});
  CHECK(parse_variation("a.b={keys=[[0,1],[1,2]]},3").values == Words{"{keys=[[0,1],[1,2]]}", "3"});
  CHECK(parse_variation("description=\"a, b\",'c,d'").values == Words{"\"a, b\"", "'c,d'"});
  CHECK(parse_variation("a.b=x=1,y=2").values == Words{"x=1", "y=2"});
}

TEST_CASE("a --vary that is none is wrong usage", "[tune]") {
  for (const char* text :
       {"", "key", "=5", "key=", "key=1,,2", "key=1,", "key=1,1", "key=[1,2", "key=\"a", "key={a=1"}) {
    CAPTURE(text);
    CHECK(error_code_of([&] { parse_variation(text); }) == 2);
  }
}

TEST_CASE("every combination is a variant with a name of its own, the last key runs fastest", "[tune]") {
  CHECK(names_of({"body.a.limit.stretch=5%,10 %", "body.a.material.young=1 kPa,2 kPa"}) ==
        Words{"stretch=5%,young=1kPa", "stretch=5%,young=2kPa", "stretch=10%,young=1kPa", "stretch=10%,young=2kPa"});
  // as much of the keys as tells them apart
  CHECK(names_of({"body.a.limit.stretch=5%", "body.b.limit.stretch=6%"}) ==
        Words{"a.limit.stretch=5%,b.limit.stretch=6%"});
  CHECK(names_of({"render.sky.map=../x y/z.hdr,.. /xy/z.hdr"}) == Words{"map=.._xy_z.hdr", "map=.._xy_z.hdr#2"});
}

TEST_CASE("too many combinations, none, and a key that is varied twice are wrong usage", "[tune]") {
  std::string many = "a.b=0";
  for (int i = 1; i < 11; ++i) many += "," + std::to_string(i);
  std::string more = many;
  more.replace(0, 3, "c.d");
  CHECK(names_of({many}).size() == 11);
  CHECK(error_code_of([&] { names_of({many, more}); }) == 2);
  CHECK(error_code_of([&] { names_of({}); }) == 2);
  CHECK(error_code_of([&] { names_of({"a.b=1,2", "a.b=3"}); }) == 2);
}

TEST_CASE("a preview changes what is costly, and nothing that the user speaks of", "[tune]") {
  const Scene scene = load_scene("figure", {{"body.figure.cage.cells", "5000"}});
  const auto keys_of = [&](const Words& chosen) {
    Words keys;
    for (const Override& setting : preview_of(scene, chosen).settings)
      keys.push_back(setting.key + "=" + setting.value);
    return keys;
  };
  CHECK(keys_of({}) == Words{"render.preview=true", "render.size=[320, 180]", "body.figure.cage.cells=400"});
  CHECK(keys_of({"render.engine", "render.size", "body.figure.cage.cells"}).empty());
  // a limit per hex means something else on another cage
  const Scene by_hex = load_scene("figure", {{"body.figure.cage.cells", "5000"}, {"body.figure.limit.energy", "1 J"}});
  for (const Override& setting : preview_of(by_hex, {}).settings) CHECK(setting.key.starts_with("render."));
  const Scene grid =
      load_scene("beam", {{"body.beam.cage.cells", "[140, 20, 20]"}, {"body.beam.limit.stretch", "5 %"}});
  CHECK(preview_of(grid, {"render.engine", "render.size"}).settings.back().value == "[27, 4, 4]");
}

TEST_CASE("a snippet is what makes the variant, in tables", "[tune]") {
  const std::vector<Override> settings{{"body.figure.limit.stretch", "5 %"},
                                       {"clip.gravity", "[0,-1,0]"},
                                       {"body.figure.material.young", "1e5"},
                                       {"description", "a test"},
                                       {"solver.energy", "true"}};
  const Scene scene = load_scene("figure", settings);
  CHECK(scene_snippet(scene, settings) ==
        "description = \"a test\"\n\n[body.figure]\nlimit.stretch = \"5 %\"\nmaterial.young = 100000\n\n[clip]\n"
        "gravity = [0, -1, 0]\n\n[solver]\nenergy = \"true\"\n");
  const std::vector<Override> preset{{"body.figure.material.preset", "gel"}};
  CHECK(scene_snippet(load_scene("figure", preset), preset) == "[body.figure]\nmaterial.preset = \"gel\"\n");
}

TEST_CASE("as many workers as threads and memory allow, and one in any case", "[tune]") {
  const std::vector<WorkItem> items(8,
                                    WorkItem{.name = {}, .words = {}, .frames = 1, .frames_done = 0, .memory = 1000});
  const auto count = [&](int threads, long long memory) {
    return count_workers(items, {.threads = threads, .memory = memory});
  };
  CHECK(count(4, 1'000'000) == 4);
  CHECK(count(64, 1'000'000) == 8);
  CHECK(count(4, 2500) == 2);
  CHECK(count(4, 10) == 1);
}

TEST_CASE("a page's pictures shrink when there are too many, and keep their shape", "[tune]") {
  int width = 320, height = 180;
  fit_page_pictures(width, height, 960);
  CHECK(width == 320);
  fit_page_pictures(width, height, 40 * 150);
  CHECK(width < 320);
  CHECK(width >= 120);
  CHECK(double(width) / height == Approx(320.0 / 180).epsilon(0.03));
}

TEST_CASE("umax tune leaves a run of each variant, a sheet, a clip and a page, resumed it makes only what is missing",
          "[tune]") {
  const TemporaryFolder folder;
  REQUIRE(exit_code_of(tune_block(folder, two_limits)) == 0);
  const fs::path out = folder / "out";
  for (const char* file : {"sheet.png", "variants.mp4", "tune.html", "tune.json", "runs/stretch=5%/clip.mp4"})
    CHECK(fs::exists(out / file));
  const nlohmann::json record = record_of(folder);
  REQUIRE(record["variants"].size() == 2);
  CHECK(record["variants"][0]["values"][0] == "5%");
  CHECK(record["variants"][0]["largest_stretch"].get<double>() < 5.01);
  CHECK(record["variants"][0]["least_share"].get<double>() <= 1);
  CHECK(file_text(out / "tune.html").find("{{") == std::string::npos);

  // the same states as a run by itself
  REQUIRE(exit_code_of({"simulate", (folder / "block.toml").string(), "--set", "clip.frames=6", "--set",
                        "body.block.limit.stretch=5%", "-o", (folder / "alone").string()}) == 0);
  CHECK(states_of(out / "runs/stretch=5%") == states_of(folder / "alone"));

  CHECK(exit_code_of(tune_block(folder, two_limits)) == 73);
  const auto before = times_of(out / "runs");
  const std::string page = file_text(out / "tune.html");
  fs::remove(out / "runs/stretch=10%/frames/0003.png");
  REQUIRE(exit_code_of(tune_block(folder, two_limits + Words{"--resume"})) == 0);
  auto after = times_of(out / "runs");
  const std::string missing = (out / "runs/stretch=10%/frames/0003.png").string();
  REQUIRE(after.count(missing) == 1);
  CHECK(after.at(missing) != before.at(missing));
  after[missing] = before.at(missing);
  CHECK(after == before);
}

TEST_CASE("a variant that was made with other settings is made anew, the others stay", "[tune]") {
  const TemporaryFolder folder;
  const Words one{"--vary", "body.block.limit.stretch=5%"};
  REQUIRE(exit_code_of(tune_block(folder, one)) == 0);
  const auto states = states_of(folder / "out/runs/stretch=5%");
  const Words stiff{"--set", "body.block.material.young=40 kPa"};
  REQUIRE(exit_code_of(tune_block(folder, two_limits + stiff + Words{"--resume"})) == 0);
  CHECK(states_of(folder / "out/runs/stretch=5%") != states);
  CHECK(record_of(folder)["variants"].size() == 2);
  REQUIRE(exit_code_of(tune_block(folder, one + Words{"--overwrite"})) == 0);
  CHECK(states_of(folder / "out/runs/stretch=5%") == states);
  CHECK_FALSE(fs::exists(folder / "out/runs/stretch=10%"));
}

TEST_CASE("the worst frame is that of the largest sum, whichever variant failed", "[tune]") {
  VariantMeasures failed, one, other;
  one.stretch = {0, 0.3, 0.1};
  other.stretch = {0, 0.1, 0.5};
  CHECK(worst_frame({one, other}) == 3);
  CHECK(worst_frame({failed, one}) == 2);
  CHECK(worst_frame({one, failed}) == 2);
  CHECK(worst_frame({failed}) == 1);
}

TEST_CASE("a variant that fails takes no other with it, and its exit code is the end's", "[tune]") {
  const TemporaryFolder folder;
  // a probe far outside of the second cage
  const ProcessResult result = umax_program(tune_block(
      folder, {"--vary", "probe.middle.point=[0, 0.24, 0],[0, 9, 0]", "--vary", "body.block.limit.stretch=5%,10%"}));
  CHECK(result.exit_code == 65);
  CHECK(result.messages.find("point=_0,9,0_,stretch=5% failed with exit code 65") != std::string::npos);
  const nlohmann::json record = record_of(folder);
  REQUIRE(record["variants"].size() == 4);
  CHECK(record["variants"][1]["exit_code"] == 0);
  CHECK(record["variants"][2]["exit_code"] == 65);
  CHECK(record["variants"][2]["failure"].get<std::string>().find("probe.middle") != std::string::npos);
  CHECK(fs::exists(folder / "out/runs/point=_0,0.24,0_,stretch=10%/clip.mp4"));
  CHECK(fs::exists(folder / "out/tune.html"));
}

TEST_CASE("what is wrong is found out before anything is made", "[tune]") {
  const TemporaryFolder folder;
  const auto result_of = [&](const Words& more) { return umax_program(tune_block(folder, more)); };
  const ProcessResult unknown = result_of({"--vary", "body.block.limit.strech=5%"});
  CHECK(unknown.exit_code == 65);
  CHECK(unknown.messages.find("--vary body.block.limit.strech: unknown key; did you mean body.block.limit.stretch?") !=
        std::string::npos);
  const ProcessResult value = result_of({"--vary", "body.block.limit.stretch=5%,5 kg"});
  CHECK(value.exit_code == 65);
  CHECK(value.messages.find("--vary body.block.limit.stretch") != std::string::npos);
  CHECK(result_of({}).exit_code == 2);
  CHECK(result_of({"--vary", "clip.frames=5,6"}).exit_code == 2);
  CHECK(result_of({"--vary", "body.block.material.preset=rubber,ruber"}).exit_code == 65);
  CHECK(exit_code_of({"tune"}) == 2);
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("without the plotting library umax tune says how to get it before the first run", "[tune]") {
  const TemporaryFolder folder;
  const ProcessResult result =
      run_process(Words{"env", "UMAX_JAVASCRIPT=/nowhere", UMAX_PROGRAM} + tune_block(folder, two_limits));
  CHECK(result.exit_code == 69);
  CHECK(result.messages.find("libjs-chart.js") != std::string::npos);
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("a tuning that is stopped stops its runs, and goes on when resumed", "[tune]") {
  const TemporaryFolder folder;
  const Words tune = tune_block(folder, two_limits + Words{"--set", "clip.frames=400"});
  // in the foreground: one signal, to umax alone; a second one would end it without waiting for its runs
  Words stopped{"timeout", "--foreground", "--signal=INT", "2", UMAX_PROGRAM};
  CHECK(run_process(stopped + tune).exit_code == 124);  // of timeout: it had to
  const fs::path runs = folder / "out/runs";
  CHECK_FALSE(fs::exists(folder / "out/tune.html"));
  CHECK_FALSE(has_half_written_files(folder / "out"));
  // no run goes on by itself
  const std::size_t found = times_of(runs).size();
  run_process({"sleep", "0.5"});
  CHECK(times_of(runs).size() == found);
  CHECK(found < 4 * 400);
}
