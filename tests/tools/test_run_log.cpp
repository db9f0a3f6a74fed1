#include "tools/run/run_log.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/support/catch.h"
#include "tests/tools/program.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The log's lines without time and process, each of which must have both.
std::vector<std::string> lines_of(const fs::path& log) {
  const std::regex stamp(R"(^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ \S+:\d+ )");
  std::vector<std::string> lines;
  std::istringstream text(file_text(log));
  for (std::string line; std::getline(text, line);) {
    CAPTURE(line);
    CHECK(std::regex_search(line, stamp));
    lines.push_back(std::regex_replace(line, stamp, ""));
  }
  return lines;
}

bool has_line(const std::vector<std::string>& lines, const std::string& beginning) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.starts_with(beginning); });
}

nlohmann::json record_of(const fs::path& run) {
  return nlohmann::json::parse(file_text(run / "run.json"));
}

/// Starts an endless simulation into folder/run and sends it a signal once its third state is there.
int end_by(const TemporaryFolder& folder, const std::string& signal) {
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const std::string script = "\"$@\" & while kill -0 $! && ! [ -e " + run +
                             "/states/0003.state ]; do sleep 0.02; done; kill -" + signal + " $!; wait $!";
  return run_process({"bash", "-c", script, "bash", UMAX_PROGRAM, "simulate", scene, "-o", run, "--set",
                      "clip.frames=100000", "--threads", "1"})
      .exit_code;
}

/// Steps that are all alike.
StepsFound even_steps(int count) {
  StepsFound steps;
  steps.rows = count;
  steps.converged.assign(std::size_t(count), true);
  for (const char* column : {"step", "frame", "time_s", "sqp_iterations", "retries", "substeps", "factorisations",
                             "linear_iterations", "contacts", "limits_active", "wall_ms"})
    steps.columns[column].assign(std::size_t(count), 4);
  for (int i = 0; i < count; ++i) steps.columns["step"][std::size_t(i)] = i + 1;
  return steps;
}

}  // namespace

TEST_CASE("the log of a run tells its machine, what differs from the defaults, and its end") {
  const TemporaryFolder folder;
  const fs::path run = folder / "run";
  const Words call{"simulate", write_scene(folder, block_scene()).string(), "-o", run.string(), "--threads", "2"};
  REQUIRE(exit_code_of(call + Words{"--frames", "1-6"}) == 0);
  const auto lines = lines_of(run / "run.log");
  for (const char* line : {"began umax simulate: ", "umax ", "machine: ", "setting body.block.limit.stretch = 0.1",
                           "setting clip.substeps = 2", "body block: ", "simulated as far as frame 6 in ",
                           "slowest of 10 steps (median ", "  step ", "ended finished; exit status 0"}) {
    CAPTURE(line);
    CHECK(has_line(lines, line));
  }
  CHECK(contains(file_text(run / "run.log"), " 2 threads used"));
  CHECK(!has_line(lines, "setting clip.fps"));
  CHECK(record_of(run)["ended"] == "finished");

  // the next call goes on behind, with its own steps
  REQUIRE(exit_code_of(call + Words{"--resume"}) == 0);
  const auto both = lines_of(run / "run.log");
  CHECK(std::equal(lines.begin(), lines.end(), both.begin()));
  CHECK(has_line(both, "slowest of 12 steps"));
  CHECK(!has_line(both, "the call before"));
}

TEST_CASE("a run that crashes says so in its record and its log, and goes on") {
  const TemporaryFolder folder;
  const fs::path run = folder / "run";
  CHECK(end_by(folder, "SEGV") == 128 + 11);
  CHECK(record_of(run)["exit_status"] == 139);
  CHECK(record_of(run)["ended"] == "crashed by SIGSEGV");
  CHECK(lines_of(run / "run.log").back() == "crashed by SIGSEGV");
  CHECK(
      !fs::exists(run / ".run.json.part-crash"));  // a state that was being written may be half there, as after a kill
  CHECK(exit_code_of({"simulate", (folder / "block.toml").string(), "-o", run.string(), "--resume"}) == 0);
  CHECK(!has_half_written_files(run));
  CHECK(record_of(run)["ended"] == "finished");
  CHECK(record_of(run)["calls_killed"] == 0);
}

TEST_CASE("a run that was killed is known as such") {
  const TemporaryFolder folder;
  const fs::path run = folder / "run";
  CHECK(end_by(folder, "KILL") == 128 + 9);
  CHECK(record_of(run)["ended"].is_null());
  const ProcessResult inspected = umax_program({"inspect", run.string(), "--json"});
  CHECK(contains(nlohmann::json::parse(inspected.output)["run"]["ended"], "without a word: killed"));
  CHECK(exit_code_of({"simulate", (folder / "block.toml").string(), "-o", run.string(), "--resume"}) == 0);
  CHECK(record_of(run)["calls_killed"] == 1);
  CHECK(has_line(lines_of(run / "run.log"), "the call before ended without a word: killed"));
}

TEST_CASE("an error that ends a run stands in its record and its log") {
  const TemporaryFolder folder;
  // a single linearisation is enough for the fall, not for the impact
  Words call{"simulate", write_scene(folder, block_scene()).string(), "-o", (folder / "run").string(), "--strict"};
  for (const char* setting : {"body.block.position=[0, 0.3, 0]", "probe.middle.point=[0, 0.3, 0]",
                              "solver.method=paper", "solver.max_iterations=1"})
    call = call + Words{"--set", setting};
  REQUIRE(exit_code_of(call) == 75);
  CHECK(contains(record_of(folder / "run")["ended"], "error: step "));
  const auto lines = lines_of(folder / "run/run.log");
  CHECK(contains(lines.back(), "did not converge"));
  CHECK(contains(lines.back(), "; exit status 75"));
}

TEST_CASE("the log counts warnings of one kind") {
  const TemporaryFolder folder;
  Progress progress(stdout, ProgressMode::plain, true);
  {
    RunLog log(progress);
    progress.warning("before there is a folder");
    log.open(folder / "run.log");
    for (const char* text : {"1 of 20 steps did not converge", "13 of 20 steps did not converge", "something else"})
      progress.warning(text);
    log.write_warnings();
  }
  progress.warning("after it is closed");
  const auto lines = lines_of(folder / "run.log");
  REQUIRE(lines.size() == 4 + 4);
  CHECK(lines.front() == "warning: before there is a folder");
  CHECK(lines[4] == "warnings: 4");
  CHECK(std::count(lines.begin(), lines.end(), "  2 x 1 of 20 steps did not converge") == 1);
  CHECK(std::count(lines.begin(), lines.end(), "  1 x something else") == 1);
}

TEST_CASE("the slowest steps are told with what they had more of than others") {
  StepsFound steps = even_steps(20);
  const auto set = [&](const char* column, std::size_t row, double value) { steps.columns[column][row] = value; };
  set("wall_ms", 7, 90), set("sqp_iterations", 7, 41), set("retries", 7, 6);
  set("wall_ms", 12, 30);
  set("wall_ms", 1, 500);  // of an earlier call
  steps.converged[7] = false;
  const auto lines = slowest_steps(steps, 5, 2);
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "slowest of 15 steps (median 4 ms):");
  CHECK(lines[1] ==
        "  step 8 (frame 4, 4 s): 90 ms; iterations 41 (median 4), halvings 6 (median 4); did not converge");
  CHECK(lines[2] == "  step 13 (frame 4, 4 s): 30 ms; nothing in it stands out");
  CHECK(slowest_steps(steps, 20, 5).empty());
  CHECK(slowest_steps(steps, 1, 1).back().ends_with("ms; the first of this call, which sets up"));
  CHECK(slowest_steps(steps, 0, 50).size() == 21);
}
