// umax farm as its user meets it, with a queue of a few functions in place of a real one. What its scripts do is in
// test_farm_scripts.cpp.
#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/farm/farm_status.h"

using namespace umax;
using umax::test::contains;
namespace fs = std::filesystem;

namespace {

/// A queue that takes down what it is told, gives numbers from 1, and refuses the job of this number.
std::string queue_that_notes(const fs::path& notes, int refused = 0) {
  return "queue_programs() { echo bash; }\njob_header() { echo '#HEAD'; }\n"
         "submit() {\n  echo \"submit $*\" >>" +
         notes.string() + "\n  local id=$(grep -c submit " + notes.string() +
         ")\n  if [ $id = " + std::to_string(refused) +
         " ]; then echo 'no such partition' >&2; return 1; fi\n  echo $id\n}\n"
         "task_index() { echo 1; }\ntask_processors() { echo 1; }\nunfinished_tasks() { cat " +
         notes.string() + ".tasks; }\ncancel() { echo \"cancel $*\" >>" + notes.string() + "; }\n";
}

struct FakeQueue {
  TemporaryFolder folder;
  std::string scene = write_scene(folder, block_scene()).string();
  fs::path notes = folder / "notes", out = folder / "out";

  ProcessResult farm(const Words& more = {}, int refused = 0) const {
    make_file(folder / "queue.sh", queue_that_notes(notes, refused));
    return umax_program(
        Words{"farm", scene, "-o", out.string(), "--queue", (folder / "queue.sh").string(), "--frames-per-job", "5"} +
        more);
  }
  void set_tasks(const std::string& text) const { make_file(notes.string() + ".tasks", text); }
};

}  // namespace

TEST_CASE("a dry run prints scripts and commands, and leaves no folder", "[farm]") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), out = (folder / "of two words").string();
  const ProcessResult one = umax_program({"farm", scene, "-o", out, "--frames-per-job", "5", "--dry-run"});
  CHECK(one.exit_code == 0);
  CHECK(contains(one.output, "simulate: sbatch --parsable --array=1-1 '" + out + "/farm/simulate.sh' 'task'\n"));
  CHECK(contains(one.output, "render: sbatch --parsable --array=1-3 --dependency=afterok:simulate '" + out +
                                 "/farm/render.sh' '1' 'task'\n"));
  CHECK(contains(one.output, "encode: sbatch --parsable --array=1-1 --dependency=afterok:render '"));
  CHECK(contains(one.output, "#SBATCH --kill-on-invalid-dep=yes"));
  CHECK(contains(one.output, "spare_seconds=60"));
  CHECK(contains(one.output, "squeue --noheader --jobs=\"$(own_task)\" --format=%L"));
  const ProcessResult two = umax_program(
      {"farm", scene, "-o", out, "--frames-per-job", "6", "--vary", "body.block.limit.stretch=5%,10%", "--dry-run"});
  CHECK(contains(two.output, "render-2: sbatch --parsable --array=1-2 --dependency=aftercorr:simulate '"));
  CHECK(contains(two.output, "encode: sbatch --parsable --array=1-2 --dependency=aftercorr:render-1:render-2 '"));
  CHECK(!fs::exists(out));
}

TEST_CASE("a farm without its queue is exit 69, says what helps, and leaves no folder", "[farm]") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  fs::create_directories(folder / "bin");
  for (const std::string program : {"bash", "ffmpeg", "ffprobe"})
    if (const auto found = find_program(program)) fs::create_symlink(*found, folder / "bin" / program);
  const ProcessResult result = run_process(
      {"env", "PATH=" + (folder / "bin").string(), UMAX_PROGRAM, "farm", scene, "-o", (folder / "out").string()});
  CHECK(result.exit_code == 69);
  CHECK(contains(result.messages, "sbatch: is not in PATH"));
  CHECK(contains(result.messages, "slurm-client"));
  CHECK(contains(result.messages, "--dry-run"));
  CHECK(!fs::exists(folder / "out"));
}

TEST_CASE("what is wrong with a farm's scene is said before it is submitted", "[farm]") {
  const FakeQueue queue;
  CHECK(queue.farm({"--set", "body.block.limit.stretch=-5%"}).exit_code == 65);
  CHECK(queue.farm({"--size", "33x18"}).exit_code == 2);
  const ProcessResult lengths = queue.farm({"--vary", "clip.frames=6,8"});
  CHECK(lengths.exit_code == 2);
  CHECK(contains(lengths.messages, "6 and 8 frames"));
  CHECK(exit_code_of({"farm"}) == 2);
  CHECK(exit_code_of({"farm", "status", (queue.folder / "nowhere").string()}) == 66);
  CHECK(exit_code_of({"farm", "cancel", queue.folder.path().string()}) == 66);
  CHECK(!fs::exists(queue.out));
  CHECK(!fs::exists(queue.notes));
}

TEST_CASE("a queue gets scripts, numbers of tasks and what they wait for, from any file of functions", "[farm]") {
  const FakeQueue queue;
  REQUIRE(queue.farm().exit_code == 0);
  const std::string scripts = (queue.out / "farm").string();
  CHECK(file_text(queue.notes) == "submit 1 - " + scripts + "/simulate.sh task\nsubmit 3 all:1 " + scripts +
                                      "/render.sh 1 task\nsubmit 1 all:2 " + scripts + "/encode.sh task\n");
  CHECK(contains(file_text(queue.out / "farm/render.sh"), "#HEAD\n"));

  // its jobs are there still: nobody else's count
  queue.set_tasks("7 RUNNING\n2 PENDING\n2 RUNNING\n2 RUNNING\n");
  const FarmStatus status = farm_status(queue.out);
  CHECK(status.tasks == std::map<std::string, int>{{"PENDING", 1}, {"RUNNING", 2}});
  CHECK(contains(farm_status_text(status, queue.out), "0 of 12 states, 0 of 12 pictures, no clip yet\n"));
  const ProcessResult again = queue.farm({"--resume"});
  CHECK(again.exit_code == 75);
  CHECK(contains(again.messages, "its job render (2) is in the queue still"));
  CHECK(queue.farm({"--overwrite"}).exit_code == 75);
  CHECK(umax_program({"farm", "cancel", queue.out.string()}).output == "3 tasks taken out of the queue\n");
  CHECK(contains(file_text(queue.notes), "cancel 2\n"));

  // none is left: what to do is said, and it goes on as the same farm only
  queue.set_tasks("");
  CHECK(contains(umax_program({"farm", "status", queue.out.string()}).output, "--resume"));
  CHECK(queue.farm().exit_code == 73);
  CHECK(queue.farm({"--resume", "--set", "body.block.limit.stretch=7%"}).exit_code == 65);
  CHECK(queue.farm({"--resume", "--vary", "body.block.limit.stretch=7%,8%"}).exit_code == 65);
  CHECK(queue.farm({"--resume"}).exit_code == 0);
  CHECK(queue.farm({"--overwrite", "--set", "body.block.limit.stretch=7%"}).exit_code == 0);
}

TEST_CASE("a job that the queue refuses takes those before it back", "[farm]") {
  const FakeQueue queue;
  const ProcessResult result = queue.farm({}, 3);
  CHECK(result.exit_code == 69);
  CHECK(contains(result.messages, "job encode: is not taken by the queue: no such partition"));
  CHECK(file_text(queue.notes).ends_with("cancel 1 2\n"));
}

TEST_CASE("a farm on this machine leaves the bytes of umax run, and counts what was lost", "[farm]") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  const fs::path out = folder / "a farm, 5 %", alone = folder / "alone";
  REQUIRE(exit_code_of({"run", scene, "-o", alone.string()}) == 0);
  const Words farm{"farm", scene, "-o", out.string(), "--queue", "here", "--frames-per-job", "5"};
  const ProcessResult result = umax_program(farm);
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  CHECK(states_of(out) == states_of(alone));
  CHECK(pictures_of(out) == pictures_of(alone));
  CHECK(steps_without_time(out) == steps_without_time(alone));
  for (const char* file : {"clip.mp4", "scene.toml", "motion.json"})
    CHECK(file_text(out / file) == file_text(alone / file));

  // a task was killed with its call, and gone on with by another one
  make_file(out / "farm/calls/render-1-2", "t h begins\nt h begins\nt h 137\nt h begins\nt h 0\n");
  const auto json = nlohmann::json::parse(umax_program({"farm", "status", out.string(), "--json"}).output);
  CHECK(json["whole"] == true);
  CHECK(json["calls"] == 7);
  CHECK(json["lost"] == 2);
  CHECK(json["recovered"] == 2);
  CHECK(contains(umax_program({"farm", "status", out.string()}).output, "all is there"));

  // what is missing comes again, and nothing else
  const auto state_time = fs::last_write_time(out / "states/0012.state");
  fs::remove(out / "frames/0007.png");
  CHECK(umax_program(farm + Words{"--resume"}).exit_code == 0);
  CHECK(pictures_of(out) == pictures_of(alone));
  CHECK(fs::last_write_time(out / "states/0012.state") == state_time);
}

TEST_CASE("a farm's task that fails says which, and where its words are", "[farm]") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  const std::string out = (folder / "out").string();
  const Words farm{"farm", scene, "-o", out, "--queue", "here"};
  REQUIRE(umax_program(farm).exit_code == 0);
  make_file(folder / "out/frames/0003.png", "not a picture");
  const ProcessResult result = umax_program(farm + Words{"--resume"});
  CHECK(result.exit_code == 69);
  CHECK(contains(result.messages, "task 1 of " + out + "/farm/encode.sh has failed"));
  CHECK(contains(file_text(folder / "out/farm/logs/encode-1.log"), "0003.png"));
}
