// umax aim from outside: what it finds on built-in scenes, what it says where there is nothing to find, and what it leaves
// behind, stopped, resumed and on any number of threads.
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/run/run_record.h"
#include "tools/run/steps_csv.h"
#include "tools/trials/snippet.h"
#include "tools/trials/trial_names.h"
#include "tools/trials/trial_runs.h"

#include "scenes/scene_file.h"

using namespace umax;
using umax::test::contains;
namespace fs = std::filesystem;

namespace {

/// A third of a second of the beam, with a small picture: half a second a run.
Words aim_beam(const TemporaryFolder& folder, const Words& more, const std::string& out = "out") {
  return Words{"aim",       "beam", "-o",    (folder / out).string(), "--size", "64x36",
               "--samples", "1",    "--set", "clip.frames=41"} +
         more;
}

const Words young{"--vary", "body.beam.material.young=50 kPa..2 MPa"};
const Words tip{"--want", "tip(tip, y) at 0.3 s = -20 cm"};

nlohmann::json record_of(const TemporaryFolder& folder, const std::string& out = "out") {
  return nlohmann::json::parse(file_text(folder / out / "aim.json"));
}

/// The miss of the run that the record calls the best.
double left_of(const nlohmann::json& record, std::size_t want = 0) {
  for (const nlohmann::json& run : record["runs"])
    if (run["name"] == record["best"]) return std::abs(run["left"][want].get<double>());
  return 1e9;
}

std::map<std::string, fs::file_time_type> times_of(const fs::path& folder) {
  std::map<std::string, fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".state") times[entry.path().string()] = entry.last_write_time();
  return times;
}

}  // namespace

TEST_CASE("umax aim finds the stiffness that bends the beam as wanted, shows it, and its lines do it", "[aim]") {
  const TemporaryFolder folder;
  const ProcessResult result = umax_program(aim_beam(folder, tip + young));
  INFO(result.output << result.messages);
  REQUIRE(result.exit_code == 0);
  const nlohmann::json record = record_of(folder);
  CHECK(record["reached"] == true);
  CHECK(record["runs"].size() <= 6);
  CHECK(left_of(record) <= 0.01);
  CHECK(contains(result.output, "run 1: before: tip(tip, y) at 0.3 s = "));
  CHECK(contains(result.output, "reached in "));
  const fs::path out = folder / "out";
  for (const char* file : {"aim.html", "before-after.png", "plot-young.svg", "lines.toml"})
    CHECK(fs::exists(out / file));
  const std::string page = file_text(out / "aim.html");
  CHECK(page.find("{{") == std::string::npos);
  CHECK(contains(page, "class=\"reached\""));
  // simulated as far as the want needs, and no further
  CHECK(states_of(out / "runs/before").size() == 33);  // pictures look at two neighbours

  // the lines in another scene, over what it says: the tip is where it was wanted
  make_file(folder / "pasted.toml", file_text(out / "lines.toml"));
  CHECK(contains(file_text(folder / "pasted.toml"), "[body.beam]\nmaterial.young = \""));
  const std::string value = record["lines"].get<std::string>();
  const std::size_t begin = value.find('"') + 1;
  REQUIRE(exit_code_of({"simulate", "beam", "--set", "clip.frames=31", "--set",
                        "body.beam.material.young=" + value.substr(begin, value.find('"', begin) - begin), "-o",
                        (folder / "alone").string()}) == 0);
  const StepsFound steps = read_steps(folder / "alone/steps.csv", steps_header({"tip"}));
  CHECK(std::abs(steps.columns.at("tip_y_m").back() + 0.2) <= 0.002);
}

TEST_CASE("umax aim says the same, whatever the number of threads, and again when resumed without a new run", "[aim]") {
  const TemporaryFolder folder;
  REQUIRE(exit_code_of(aim_beam(folder, tip + young + Words{"--threads", "1"}, "one")) == 0);
  REQUIRE(exit_code_of(aim_beam(folder, tip + young + Words{"--threads", "3"}, "three")) == 0);
  CHECK(record_of(folder, "one") == record_of(folder, "three"));
  CHECK(exit_code_of(aim_beam(folder, tip + young, "one")) == 73);
  const auto before = times_of(folder / "one");
  const nlohmann::json record = record_of(folder, "one");
  REQUIRE(exit_code_of(aim_beam(folder, tip + young + Words{"--resume"}, "one")) == 0);
  CHECK(times_of(folder / "one") == before);
  CHECK(record_of(folder, "one") == record);
  // another search in its place leaves nothing of the first
  const Words limit{"--vary", "body.beam.limit.energy=0.01J..1J"};
  REQUIRE(exit_code_of(aim_beam(folder, Words{"--want", "tip(tip, y) at 0.3 s = -40 cm"} + limit + Words{"--overwrite"},
                                "one")) == 0);
  CHECK_FALSE(fs::exists(folder / "one/plot-young.svg"));
  CHECK(fs::exists(folder / "one/plot-energy.svg"));
  for (const auto& entry : fs::directory_iterator(folder / "one/runs"))
    CHECK_FALSE(contains(entry.path().filename().string(), "young"));
}

TEST_CASE("umax aim ends with 3 where the want is out of range or nothing changes it, and shows the nearest", "[aim]") {
  const TemporaryFolder folder;
  const ProcessResult result = umax_program(aim_beam(folder, Words{"--want", "tip(tip, y) at 0.3 s = -5 cm"} + young));
  INFO(result.output << result.messages);
  CHECK(result.exit_code == 3);
  CHECK(contains(result.output, "not reached: out of range: with body.beam.material.young at the upper end"));
  CHECK(record_of(folder)["best"] == "young=2MPa");
  CHECK(contains(file_text(folder / "out/aim.html"), "class=\"missed\""));
  CHECK(fs::exists(folder / "out/before-after.png"));

  // beyond some softness the beam swings back earlier
  const ProcessResult turn =
      umax_program(aim_beam(folder, Words{"--want", "tip(tip, y) at 0.3 s = -90 cm"} + young, "turn"));
  CHECK(turn.exit_code == 3);
  CHECK(contains(turn.output, "not reached: not monotone: it turns round"));
  CHECK(record_of(folder, "turn")["runs"].size() <= 10);

  const ProcessResult flat =
      umax_program(aim_beam(folder, tip + Words{"--vary", "body.beam.friction=0.1..0.9"}, "flat"));
  CHECK(flat.exit_code == 3);
  CHECK(contains(flat.output, "body.beam.friction changes nothing"));
}

TEST_CASE("umax aim brings two wants about with two keys", "[aim]") {
  const TemporaryFolder folder;
  const ProcessResult result = umax_program(
      aim_beam(folder, Words{"--want", "tip(tip, y) at 0.3 s = -45 cm", "--want",
                             "max stretch(beam) from 0 s to 0.3 s = 6 %", "--vary", "body.beam.limit.stretch=2%..20%"} +
                           young));
  INFO(result.output << result.messages);
  REQUIRE(result.exit_code == 0);
  const nlohmann::json record = record_of(folder);
  CHECK(left_of(record, 0) <= 0.01);
  CHECK(left_of(record, 1) <= 0.01);
  CHECK(record["runs"].size() <= 20);
  CHECK(fs::exists(folder / "out/plot-young.svg"));
  CHECK(fs::exists(folder / "out/plot-stretch.svg"));
}

TEST_CASE("what is wrong with an aim is found out before anything is made", "[aim]") {
  const TemporaryFolder folder;
  const auto code_of = [&](const Words& more) { return exit_code_of(aim_beam(folder, more)); };
  CHECK(code_of({}) == 2);
  CHECK(code_of(tip) == 2);
  CHECK(code_of(young) == 2);
  CHECK(code_of(tip + young + young) == 2);
  CHECK(code_of(tip + tip + tip + tip + young) == 2);
  CHECK(code_of(Words{"--want", "tip(top, y) at 0.3 s = -20 cm"} + young) == 2);
  CHECK(code_of(tip + Words{"--vary", "body.beam.material.yong=1..2"}) == 65);
  CHECK(exit_code_of({"aim"}) == 2);
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("a run that fails ends the aim with its exit code and names it", "[aim]") {
  const TemporaryFolder folder;
  // at a tenth of its size no node is where some shall stay
  const std::string scene = write_scene(folder, block_scene()).string();
  const ProcessResult result = umax_program(
      {"aim", scene, "-o", (folder / "out").string(), "--want", "height(block) at 0.1 s = 99 %", "--set",
       "body.block.fixed=[{ min = [-1, 0.35, -1], max = [1, 1, 1] }]", "--vary", "body.block.scale=0.1..2"});
  INFO(result.messages);
  CHECK(result.exit_code == 65);
  CHECK(contains(result.messages, "scale=0.1 failed with exit code 65"));
  CHECK_FALSE(fs::exists(folder / "out/aim.html"));
}

TEST_CASE("an aim that is stopped or killed goes on when resumed, to the same result", "[aim][slow]") {
  const TemporaryFolder folder;
  // fine steps, so that it lasts
  const Words long_aim = tip + young + Words{"--set", "clip.substeps=15"};
  REQUIRE(exit_code_of(aim_beam(folder, long_aim, "whole")) == 0);
  for (const char* signal : {"INT", "KILL"}) {
    CAPTURE(signal);
    Words stopped{"timeout", "--foreground", "--signal", signal, "1", UMAX_PROGRAM};
    const int code = run_process(stopped + aim_beam(folder, long_aim, signal)).exit_code;
    CHECK((code == 124 || code == 137));  // of timeout: it had to
    CHECK_FALSE(fs::exists(folder / signal / "aim.html"));
    // a killed one's run ends after its frame, and holds its folder until then
    int resumed = 75;
    for (int i = 0; i < 20 && resumed == 75; ++i) {
      run_process({"sleep", "0.5"});
      resumed = exit_code_of(aim_beam(folder, long_aim + Words{"--resume"}, signal));
    }
    REQUIRE(resumed == 0);
    CHECK(record_of(folder, signal) == record_of(folder, "whole"));
    CHECK(states_of(folder / signal / "runs/before") == states_of(folder / "whole/runs/before"));
  }
}

TEST_CASE("a trial that was killed behind its last state has work left, and one that has ended has not", "[aim]") {
  const TemporaryFolder folder;
  const TrialRun trial{"block", folder / "trial.toml", folder / "run"};
  const std::string file = write_scene(folder, block_scene()).string();
  REQUIRE(exit_code_of({"simulate", file, "-o", trial.run.string()}) == 0);
  const Scene scene = load_scene(file);
  Progress progress(stdout, ProgressMode::plain, true);
  const TrialGoal goal{.last_frame = 12};
  CHECK(!missing_work(trial, scene, goal, true, progress));

  RunRecord record = read_run_record(trial.run / "run.json").value();
  record.exit_status.reset();
  record.ended.clear();
  write_run_record(trial.run / "run.json", record);
  fs::remove(trial.run / "motion.json");
  const auto left = missing_work(trial, scene, goal, true, progress);
  REQUIRE(left);
  CHECK(umax_program(left->words).exit_code == 0);
  CHECK(fs::exists(trial.run / "motion.json"));
  CHECK(!missing_work(trial, scene, goal, true, progress));
}

TEST_CASE("the value of a key is read back from a scene, of parts of its things too", "[aim]") {
  const Scene beam = load_scene("beam");
  CHECK(value_in_scene(beam, "body.beam.limit.energy") == "0.1");
  CHECK(value_in_scene(beam, "body.beam.limit.stretch") == std::nullopt);
  CHECK(value_in_scene(beam, "body.bream.limit.energy") == std::nullopt);
  CHECK(value_in_scene(beam, "clip.frames") == "201");
  CHECK(value_in_scene(beam, "nothing.at.all") == std::nullopt);
  const Scene puppet = load_scene("puppet");
  REQUIRE(!puppet.pins.empty());
  const std::string pin = "body." + puppet.pins.front().body + ".pin." + puppet.pins.front().name;
  const Scene soft = load_scene("puppet", {{pin + ".stiffness", "750 N/m"}});
  CHECK(value_in_scene(soft, pin + ".stiffness") == "750");
  CHECK(scene_snippet(soft, {{pin + ".stiffness", "750 N/m"}}) == "[" + pin + "]\nstiffness = \"750 N/m\"\n");
}

TEST_CASE("words of a command are quoted so that a shell reads them back", "[aim]") {
  for (const char* word : {"plain", "a.b=5%", "5 %", "it's", "", "$HOME `x` \"y\"", "a;b", "[1, 2]", "*"}) {
    CAPTURE(word);
    CHECK(run_process({"sh", "-c", "printf %s " + shell_word(word)}).output == word);
  }
  CHECK(shell_word("a.b=5%") == "a.b=5%");
}
