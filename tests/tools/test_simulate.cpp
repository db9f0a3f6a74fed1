#include <algorithm>

#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/run/step_plots.h"
#include "tools/run/steps_csv.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// Simulates the block scene in one go into `folder`/whole.
fs::path simulate_whole(const TemporaryFolder& folder, const fs::path& scene) {
  const ProcessResult result =
      umax_program({"simulate", scene.string(), "-o", (folder / "whole").string(), "--threads", "1"});
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  return folder / "whole";
}

void check_same_run(const fs::path& a, const fs::path& b) {
  CHECK(states_of(a) == states_of(b));
  CHECK(steps_without_time(a) == steps_without_time(b));
  for (const std::string name : step_plot_names) {
    CAPTURE(name);
    CHECK(fs::exists(a / "plots" / name));
    if (name != "wall_ms.svg") CHECK(file_text(a / "plots" / name) == file_text(b / "plots" / name));
  }
}

}  // namespace

TEST_CASE("a run leaves what the contract promises") {
  const TemporaryFolder folder;
  const fs::path run = simulate_whole(folder, write_scene(folder, block_scene()));
  CHECK(states_of(run).size() == 12);
  CHECK(fs::exists(run / "states/0001.state"));
  CHECK(fs::exists(run / "states/0012.state"));
  const std::string steps = file_text(run / "steps.csv");
  CHECK(steps.substr(0, steps.find('\n')) == steps_header({"middle"}));
  CHECK(std::count(steps.begin(), steps.end(), '\n') == 1 + 11 * 2);
  const std::string record = file_text(run / "run.json");
  CHECK(record.find("\"steps\": 22") != std::string::npos);
  CHECK(record.find("\"exit_status\": 0") != std::string::npos);
  CHECK(!has_half_written_files(run));
}

TEST_CASE("two threads give the same states as one") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), one = simulate_whole(folder, scene);
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (folder / "two").string(), "--threads", "2"}) == 0);
  check_same_run(one, folder / "two");
}

TEST_CASE("a simulation split over several calls gives the same states") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = simulate_whole(folder, scene);
  const Words split{"simulate", scene.string(), "-o", (folder / "split").string(), "--resume"};
  for (const char* frames : {"1", "1-5", "3", "9,6", "1-12"})
    REQUIRE(exit_code_of(split + Words{"--frames", frames}) == 0);
  check_same_run(whole, folder / "split");
}

TEST_CASE("a run that was killed goes on to the same states") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = simulate_whole(folder, scene),
                 run = folder / "killed";
  const Words simulate{UMAX_PROGRAM, "simulate", scene.string(), "-o", run.string(), "--resume"};
  // killed at growing ages, until one call lives to its end
  int code = -1, kills = 0;
  for (double seconds = 0.02; code != 0 && kills < 60; seconds *= 1.3, ++kills)
    code = run_process(Words{"timeout", "-s", "KILL", std::to_string(seconds)} + simulate).exit_code;
  CHECK(code == 0);
  CHECK(kills > 0);
  check_same_run(whole, run);
}

TEST_CASE("a run that is asked to stop keeps what is complete and says which signal it was") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const std::string stop_in_the_middle = "\"$@\" & while kill -0 $! && ! [ -e " + run +
                                         "/states/0003.state ]; do sleep 0.02; done; kill -TERM $!; wait $!";
  const Words simulate{UMAX_PROGRAM, "simulate", scene, "-o", run, "--set", "clip.frames=100000"};
  CHECK(run_process(Words{"bash", "-c", stop_in_the_middle, "bash"} + simulate).exit_code == 128 + 15);
  CHECK(file_text(folder / "run/run.json").find("\"exit_status\": 143") != std::string::npos);
  for (const char* name : step_plot_names) CHECK(fs::exists(folder / "run/plots" / name));
  CHECK(!has_half_written_files(run));
}

TEST_CASE("a deadline ends a run with what is complete, and it goes on") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const Words simulate{"simulate", scene, "-o", run, "--set", "clip.frames=100000", "--deadline"};
  const ProcessResult first = umax_program(simulate + Words{"0.01 min"});
  CHECK(first.exit_code == 75);
  CHECK(first.output.find("stopped by the deadline; what is finished is kept, --resume goes on") != std::string::npos);
  CHECK(file_text(folder / "run/run.json").find("\"exit_status\": 75") != std::string::npos);
  CHECK(!has_half_written_files(run));
  std::size_t kept = files_in(folder / "run/states").size();
  for (const std::size_t wanted :
       {kept + 1, kept + 2}) {                           // more after the first call, and more than that after another
    for (const char* longer : {"600ms", "3 s", "20 s"})  // as long as a busy machine needs
      if (kept < wanted) {
        CHECK(exit_code_of(simulate + Words{longer, "--resume"}) == 75);
        const std::size_t now = files_in(folder / "run/states").size();
        CHECK(now >= kept);
        kept = now;
      }
    CHECK(kept >= wanted);
  }
  for (const char* deadline : {"soon", "0", "-1 h", "3 kg"})
    CHECK(exit_code_of({"simulate", scene, "-o", run, "--resume", "--deadline", deadline}) == 2);
}

TEST_CASE("a run that is asked to stop does so in the middle of a step") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), log = (folder / "log").string();
  const Words endless{"--set", "body.block.limit.stretch=\"0.001 %\"", "--set", "solver.tolerance=1e-12",
                      "--set", "solver.max_newton_iterations=1000000"};  // whose step is never solved
  const std::string stop_in_a_step = "timeout --foreground -s KILL 60 \"$@\" > " + log +
                                     " 2>&1 & while kill -0 $! && ! grep -q 'iteration 99:' " + log +
                                     "; do sleep 0.02; done; kill -TERM $!; wait $!";
  const Words simulate{UMAX_PROGRAM, "simulate", scene, "-o", (folder / "run").string(), "--verbose"};
  CHECK(run_process(Words{"bash", "-c", stop_in_a_step, "bash"} + simulate + endless).exit_code == 128 + 15);
  CHECK(file_text(folder / "run/run.json").find("\"exit_status\": 143") != std::string::npos);
  CHECK(!has_half_written_files(folder / "run"));
}

TEST_CASE("the scene as resolved gives the same run") {
  const TemporaryFolder folder;
  const fs::path whole = simulate_whole(folder, write_scene(folder, block_scene()));
  REQUIRE(exit_code_of({"simulate", (whole / "scene.toml").string(), "-o", (folder / "again").string()}) == 0);
  check_same_run(whole, folder / "again");
  CHECK(file_text(whole / "scene.toml") == file_text(folder / "again/scene.toml"));
}

TEST_CASE("a damaged state is said and computed again") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = simulate_whole(folder, scene);
  const auto before = states_of(whole);
  const std::string steps = steps_without_time(whole);
  SECTION("cut short") {
    make_file(whole / "states/0012.state", before.at("0012.state").substr(0, 200));
  }
  SECTION("empty") {
    make_file(whole / "states/0012.state", "");
  }
  SECTION("two of them") {
    make_file(whole / "states/0011.state", "UMAXSTAT");
    make_file(whole / "states/0012.state", "nonsense");
  }
  SECTION("missing in the middle") {
    fs::remove(whole / "states/0004.state");
  }
  SECTION("steps.csv cut off") {
    make_file(whole / "steps.csv", file_text(whole / "steps.csv").substr(0, 700));
  }
  const ProcessResult result = umax_program({"simulate", scene.string(), "-o", whole.string(), "--resume"});
  INFO(result.messages);
  CHECK(result.exit_code == 0);
  CHECK(states_of(whole) == before);
  CHECK(steps_without_time(whole) == steps);
}

TEST_CASE("states of another scene are refused and kept") {
  const TemporaryFolder folder;
  const fs::path whole = simulate_whole(folder, write_scene(folder, block_scene()));
  const auto before = states_of(whole);
  const std::string scene = file_text(whole / "scene.toml");
  CHECK(exit_code_of({"simulate", (folder / "block.toml").string(), "-o", whole.string(), "--resume", "--set",
                      "body.block.material.young=30kPa"}) == 65);
  CHECK(states_of(whole) == before);
  CHECK(file_text(whole / "scene.toml") == scene);
  CHECK(exit_code_of({"simulate", (folder / "block.toml").string(), "-o", whole.string(), "--overwrite", "--set",
                      "body.block.material.young=30kPa"}) == 0);
  CHECK(states_of(whole) != before);
}

TEST_CASE("a clip may be made longer afterwards") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = simulate_whole(folder, scene);
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (folder / "grown").string(), "--set", "clip.frames=4"}) == 0);
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (folder / "grown").string(), "--resume"}) == 0);
  check_same_run(whole, folder / "grown");
}

TEST_CASE("plots that are missing are drawn again though there is nothing left to simulate") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), whole = simulate_whole(folder, scene);
  const std::string before = file_text(whole / "plots/wall_ms.svg");
  fs::remove_all(whole / "plots");
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", whole.string(), "--resume"}) == 0);
  CHECK(file_text(whole / "plots/wall_ms.svg") == before);
  fs::remove_all(whole / "plots");
  make_file(whole / "plots", "in the way");
  CHECK(exit_code_of({"simulate", scene.string(), "-o", whole.string(), "--resume"}) == 74);
}

TEST_CASE("a strict run that ends at a step that did not converge has plots of those before") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene());
  // a single linearisation is enough for the fall, not for the impact
  Words simulate{"simulate", scene.string(), "-o", (folder / "run").string(), "--strict"};
  for (const char* setting : {"body.block.position=[0, 0.3, 0]", "probe.middle.point=[0, 0.3, 0]",
                              "solver.method=paper", "solver.max_iterations=1"})
    simulate = simulate + Words{"--set", setting};
  CHECK(exit_code_of(simulate) == 75);
  CHECK(states_of(folder / "run").size() > 2);
  CHECK(fs::exists(folder / "run/plots/max_energy_ratio.svg"));
}

TEST_CASE("a run without a step has plots too") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene());
  CHECK(exit_code_of({"simulate", scene.string(), "-o", (folder / "run").string(), "--frames", "1"}) == 0);
  for (const char* name : step_plot_names) CHECK(fs::exists(folder / "run/plots" / name));
}
