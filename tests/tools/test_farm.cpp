// umax farm: the jobs and their scripts, a queue of a few functions in place of a real one, and what jobs do when umax is
// killed in them. tests/clients/farm_on_slurm.py has the real queue.
#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tests/tools/program.h"
#include "tools/farm/farm_plan.h"
#include "tools/farm/farm_record.h"
#include "tools/farm/farm_scripts.h"
#include "tools/farm/farm_status.h"

using namespace umax;
using umax::test::contains;
namespace fs = std::filesystem;

namespace {

FarmPlan plan_of(int num_runs, int num_frames, int frames_per_job) {
  FarmPlan plan;
  plan.name = "block";
  plan.is_varied = num_runs > 1;
  plan.num_frames = num_frames;
  plan.frames_per_job = frames_per_job;
  for (int i = 1; i <= num_runs; ++i) plan.runs.push_back({"stretch=" + std::to_string(i) + "%", "scene", "block"});
  return plan;
}

/// What bash prints for a command behind a script of functions.
std::string bash(const std::string& text) {
  const ProcessResult result = run_process({"bash", "-euc", text});
  INFO(text << result.messages);
  CHECK(result.exit_code == 0);
  return result.output;
}

std::string script_named(const std::vector<FarmScript>& scripts, const std::string& name) {
  for (const FarmScript& script : scripts)
    if (script.name == name) return script.text;
  return "";
}

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

/// Calls go_on of task_functions.sh with a umax that ends with these codes, one after the other, then with 0, and leaves a
/// state each time. more: commands before it. The clock of the shell stands still at 0 unless they turn it.
struct Attempts {
  int code = 0;
  std::string calls;   // "begins 137 begins 0"
  std::string output;  // of the calls
};
Attempts go_on(const std::string& codes, const std::string& more = ":") {
  const TemporaryFolder folder;
  const FarmPlan plan = plan_of(1, 10, 5);
  const FarmPaths paths = farm_paths(folder.path(), false);
  fs::create_directories(paths.calls());
  make_file(paths.queue(), queue_functions("slurm"));
  make_file(folder / "codes", codes);
  make_file(folder / "umax", "#!/bin/bash\nread -r code rest <" + (folder / "codes").string() + "\necho \"$rest\" >" +
                                 (folder / "codes").string() + "\nmktemp -qp " + (folder / "states").string() +
                                 " >/dev/null\nexit ${code:-0}\n");
  fs::create_directories(folder / "states");
  fs::permissions(folder / "umax", fs::perms::owner_all);
  make_file(paths.farm() / "task.sh",
            script_named(farm_scripts(plan, paths, queue_functions("slurm"), (folder / "umax").string()), "task.sh"));
  const ProcessResult result =
      run_process({"bash", "-c",
                   ". " + (paths.farm() / "task.sh").string() + "; sleep() { :; }; unset SECONDS; SECONDS=0; " +
                       "run=1 most_lost=2 most_waits=3; " + more + "; go_on call render DIR"});
  INFO(result.messages);
  return {result.exit_code, bash("cut -d' ' -f3 " + (paths.calls() / "call").string() + " | paste -sd' '"),
          result.output};
}

}  // namespace

TEST_CASE("the jobs of one run wait for all of the one before, and its chunks reach to the end of the clip", "[farm]") {
  const std::vector<FarmJob> jobs = jobs_of(plan_of(1, 20, 8));
  REQUIRE(jobs.size() == 3);
  CHECK(jobs[0].tasks == 1);
  CHECK(jobs[0].waiting == Waiting::for_none);
  CHECK(jobs[1].tasks == 3);
  CHECK(jobs[1].waiting == Waiting::for_all);
  CHECK(jobs[1].words == Words{"1", "task"});
  CHECK(jobs[1].after == std::vector<std::size_t>{0});
  CHECK(jobs[2].waiting == Waiting::for_all);
  CHECK(jobs[2].after == std::vector<std::size_t>{1});
  CHECK(jobs_of(plan_of(1, 16, 8))[1].tasks == 2);
  CHECK(jobs_of(plan_of(1, 3, 8))[1].tasks == 1);
}

TEST_CASE("each variant of a farm waits for its own jobs only", "[farm]") {
  const std::vector<FarmJob> jobs = jobs_of(plan_of(2, 20, 8));
  REQUIRE(jobs.size() == 5);
  for (const FarmJob& job : jobs) CHECK(job.tasks == 2);
  for (std::size_t chunk = 1; chunk <= 3; ++chunk) {
    CHECK(jobs[chunk].waiting == Waiting::for_each);
    CHECK(jobs[chunk].words == Words{"task", std::to_string(chunk)});
    CHECK(jobs[chunk].after == std::vector<std::size_t>{0});
  }
  CHECK(jobs[4].waiting == Waiting::for_each);
  CHECK(jobs[4].after == std::vector<std::size_t>{1, 2, 3});
}

TEST_CASE("scripts of a farm keep paths whole, whatever signs they have", "[farm]") {
  const FarmPaths paths = farm_paths("/disk of all/it's 5 % $HOME \"x\"", true);
  const std::vector<FarmScript> scripts = farm_scripts(plan_of(2, 20, 8), paths, queue_functions("slurm"), "/a b/umax");
  // what they read is not there
  std::string task = script_named(scripts, "task.sh");
  task.erase(task.find("\n. ") + 1, task.find("\numax=") - task.find("\n. "));
  CHECK(bash(task + "\nprintf '%s\\n' \"$umax\" \"${scenes[@]}\" \"${runs[@]}\" \"$calls\"") ==
        "/a b/umax\n" + (paths.farm() / "scenes/stretch=1%.toml").string() + "\n" +
            (paths.farm() / "scenes/stretch=2%.toml").string() + "\n" + (paths.path / "runs/stretch=1%").string() +
            "\n" + (paths.path / "runs/stretch=2%").string() + "\n" + paths.calls().string() + "\n");
  const std::string render = script_named(scripts, "render.sh");
  CHECK(contains(render, "#SBATCH --output=\"/disk of all/it's 5 %% $HOME \\\"x\\\"/farm/logs/render-%A-%a.log\""));
  CHECK(render.starts_with("#!"));
  for (const FarmScript& script : scripts) {
    CAPTURE(script.name);
    make_file(output_folder() / "script.sh", script.text);
    CHECK(run_process({"bash", "-n", (output_folder() / "script.sh").string()}).exit_code == 0);
  }
}

TEST_CASE("what a farm asks its queue for stands at the head of the scripts", "[farm]") {
  FarmPlan plan = plan_of(1, 20, 8);
  const auto simulate = [&] {
    return script_named(farm_scripts(plan, farm_paths("/x", false), queue_functions("slurm"), "umax"), "simulate.sh");
  };
  CHECK(!contains(simulate(), "--cpus-per-task"));
  CHECK(!contains(simulate(), "--mem"));
  plan.processors = 6;
  plan.memory = 3LL << 30;
  CHECK(contains(simulate(), "#SBATCH --cpus-per-task=6\n"));
  CHECK(contains(simulate(), "#SBATCH --mem=3072M\n"));
  plan.isa = "avx2";
  CHECK(contains(script_named(farm_scripts(plan, farm_paths("/x", false), queue_functions("slurm"), "umax"), "task.sh"),
                 "export UMAX_ISA=avx2\n"));
}

TEST_CASE("a job goes on after a kill and waits for a folder in use, and ends with what would come again", "[farm]") {
  const auto check = [](const std::string& codes, int code, const std::string& calls) {
    CAPTURE(codes);
    const Attempts attempts = go_on(codes);
    CHECK(attempts.code == code);
    CHECK(attempts.calls == calls + "\n");
  };
  check("", 0, "begins 0");
  check("137 75 74", 0, "begins 137 begins 75 begins 74 begins 0");
  check("65", 65, "begins 65");
  check("2", 2, "begins 2");
  check("70", 70, "begins 70");
  check("137 139 134 0", 134, "begins 137 begins 139 begins 134");
  check("75 75 75 75", 75, "begins 75 begins 75 begins 75 begins 75");
}

TEST_CASE("a task whose deadline is over goes back into the queue, and one that waits for a folder does not",
          "[farm]") {
  const std::string requeue = "requeue_task() { note_call call requeued; SECONDS=0; }; deadline_seconds=50;";
  CHECK(go_on("75 0", requeue + "SECONDS=50").calls == "begins 75 requeued begins 0\n");
  CHECK(go_on("75 0", requeue + "SECONDS=20").calls == "begins 75 begins 0\n");
  CHECK(go_on("75 0", "requeue_task() { return 1; }; deadline_seconds=50 SECONDS=60").code == 1);

  // a call gets what is left of it
  CHECK(go_on("", requeue + "SECONDS=20; umax=echo").output == "render DIR --progress plain --deadline 30\n");
  CHECK(go_on("", requeue + "SECONDS=70; umax=echo").output == "render DIR --progress plain --deadline 1\n");
  CHECK(go_on("", "umax=echo").output == "render DIR --progress plain\n");
}

TEST_CASE("a task ends before its queue cuts it off, and one that finishes nothing in its time does not come again",
          "[farm]") {
  const auto deadline = [](const std::string& left, const std::string& more = "") {
    return go_on("",
                 "SLURM_JOB_ID=9 SLURM_ARRAY_JOB_ID=5 SLURM_ARRAY_TASK_ID=3 umax=echo; squeue() { [ $2 = --jobs=5_3 ] "
                 "&& echo " +
                     left + "; }; " + more + ":")
        .output;
  };
  CHECK(deadline("10:00") == "render DIR --progress plain --deadline 540\n");
  CHECK(deadline("1-01:00:30") == "render DIR --progress plain --deadline 89970\n");
  CHECK(deadline("2:08:09") == "render DIR --progress plain --deadline 7629\n");
  CHECK(deadline("1:30") == "render DIR --progress plain --deadline 45\n");
  CHECK(deadline("0:00") == "render DIR --progress plain --deadline 1\n");
  CHECK(deadline("10:00", "deadline_seconds=50; ") == "render DIR --progress plain --deadline 50\n");
  CHECK(deadline("10:00", "deadline_seconds=900; ") == "render DIR --progress plain --deadline 540\n");
  for (const char* unlimited : {"UNLIMITED", "NOT_SET", "INVALID", "''"})
    CHECK(deadline(unlimited) == "render DIR --progress plain\n");
  CHECK(deadline("10:00", "unset -f task_seconds_left; ") == "render DIR --progress plain\n");  // of another queue

  const std::string cut =
      "SLURM_JOB_ID=5; squeue() { echo 1:00; }; requeue_task() { note_call call requeued; squeue() { "
      "echo 9:00; }; }; umax() { SECONDS=$((SECONDS + 30)); \"$fake\" \"$@\"; }; fake=$umax umax=umax";
  CHECK(go_on("75 0", cut).calls == "begins 75 requeued begins 0\n");
  const Attempts idle = go_on("75 0", cut + "; frames_finished() { echo 7; }");
  CHECK(idle.calls == "begins 75\n");
  CHECK(idle.code == 75);
  CHECK(contains(idle.output, "nothing was finished in the time"));
}

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
