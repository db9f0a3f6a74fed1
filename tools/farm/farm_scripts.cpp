#include "tools/farm/farm_scripts.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/farm/farm_files.h"
#include "tools/trials/trial_names.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// Paths as words of a list in bash, one a line.
std::string word_list(const std::vector<fs::path>& paths) {
  std::string list = "(\n";
  for (const fs::path& path : paths) list += "  " + shell_word(path.string()) + "\n";
  return list + ")";
}

/// What pins the instruction set of every call on every machine; nothing where each machine is to use its best.
std::string isa_line(const FarmPlan& plan) {
  return plan.isa.empty() ? "" : "export UMAX_ISA=" + plan.isa + "\n";
}

std::string task_script(const FarmPlan& plan, const FarmPaths& paths, const std::string& program) {
  std::vector<fs::path> scenes, runs;
  for (const FarmRun& run : plan.runs) {
    scenes.push_back(paths.scene(run.name));
    runs.push_back(paths.run(run.name));
  }
  return fmt::format(
             R"(# What the jobs of this farm share. Each reads it when it begins: what is changed here holds for those to come.
. {queue}
umax={program}
{isa}# run 1, run 2, …: the scene that is simulated, and the folder of its run
scenes={scenes}
runs={runs}
frames_per_job={chunk}
simulate_options={options}
calls={calls}
deadline_seconds={seconds}  # after which a task goes back into the queue, from its beginning; 0: only before the queue cuts it off
spare_seconds=60  # by which it ends before that; half of what is left where that is less than twice as much
most_lost=5      # times that a task goes on after umax was killed, crashed or could not write
most_waits=60    # times that it waits for a folder in which another umax is at work
wait_seconds=10

)",
             fmt::arg("queue", shell_word(paths.queue().string())), fmt::arg("program", shell_word(program)),
             fmt::arg("isa", isa_line(plan)), fmt::arg("scenes", word_list(scenes)), fmt::arg("runs", word_list(runs)),
             fmt::arg("chunk", plan.frames_per_job),
             fmt::arg("options", plan.memory > 0 ? fmt::format("(--memory {})", plan.memory) : "()"),
             fmt::arg("calls", shell_word(paths.calls().string())),
             fmt::arg("seconds", (long long)(std::ceil(plan.deadline)))) +
         farm_file("task_functions.sh");
}

/// A job's script: its head, what all share, and what it does.
FarmScript job_script(const std::string& stage, const FarmPlan& plan, const FarmPaths& paths,
                      const QueueFunctions& queue) {
  const std::string name = folder_name(plan.name) + "-" + stage;
  const std::string log = (paths.logs() / stage).string();
  const std::string head = job_header(queue, name, log, {.processors = plan.processors, .memory = plan.memory});
  return {stage + ".sh", fmt::format("#!/usr/bin/env bash\n{}. {}\n\n{}", head,
                                     shell_word((paths.farm() / "task.sh").string()), farm_file(stage + ".sh"))};
}

}  // namespace

std::vector<FarmScript> farm_scripts(const FarmPlan& plan, const FarmPaths& paths, const QueueFunctions& queue,
                                     const std::string& program) {
  return {{"queue.sh", queue},
          {"task.sh", task_script(plan, paths, program)},
          job_script("simulate", plan, paths, queue),
          job_script("render", plan, paths, queue),
          job_script("encode", plan, paths, queue)};
}

}  // namespace umax
