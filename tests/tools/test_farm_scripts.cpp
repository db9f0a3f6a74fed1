// The jobs of a farm, and what their scripts do when umax is killed in them. tests/clients/farm_on_slurm.py has a real queue.
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/farm/farm_plan.h"
#include "tools/farm/farm_scripts.h"

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
