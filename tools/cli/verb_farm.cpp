#include <fmt/format.h>

#include <cstdio>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/farm/farm.h"
#include "tools/farm/farm_status.h"

namespace umax {
namespace {

std::vector<std::string> scenes_and_words() {
  std::vector<std::string> words = scene_names();
  words.insert(words.end(), {"status", "cancel"});
  return words;
}

FarmRequest request_of(const Options& options) {
  FarmRequest request{.scene = single_input(options, "scene, or status DIR, or cancel DIR"),
                      .settings = scene_overrides(options),
                      .variations = options.variations};
  if (options.frames_per_job) request.frames_per_job = *options.frames_per_job;
  request.processors = options.threads.value_or(0);
  request.memory = memory_limit(options);
  request.isa = options.isa;
  request.deadline = deadline_of(options).value_or(0);
  return request;
}

int submit(const Options& options) {
  const QueueFunctions queue = queue_functions(options.queue.value_or("slurm"));
  const FarmPlan plan = plan_farm(request_of(options));
  const std::filesystem::path folder = output_folder(options, plan.name + (plan.is_varied ? "-farm" : ""));
  if (options.dry_run) {
    fmt::print("{}", farm_dry_run(plan, folder, queue));
    return 0;
  }
  Progress progress(stdout, progress_mode(options), options.quiet);
  submit_farm(plan, folder, existing_folder(options), queue, progress);
  return 0;
}

int farm(const Options& options) {
  const std::string word = options.inputs.size() == 2 ? options.inputs.front() : "";
  if (word == "status") {
    const FarmStatus status = farm_status(options.inputs[1]);
    fmt::print("{}", options.json ? farm_status_json(status) : farm_status_text(status, options.inputs[1]));
    return 0;
  }
  if (word == "cancel") {
    const int tasks = cancel_farm(options.inputs[1]);
    fmt::print("{} {} taken out of the queue\n", tasks, tasks == 1 ? "task" : "tasks");
    return 0;
  }
  return submit(options);
}

}  // namespace

Verb farm_verb() {
  return {.name = "farm",
          .usage = "SCENE | status DIR | cancel DIR",
          .summary = "the same run as job arrays on a queue",
          .details =
              "Writes the scripts of jobs into DIR/farm and submits them to Slurm: one simulates, an array draws "
              "--frames-per-job frames in each of its tasks once all is simulated, one makes the clip. The states, "
              "pictures and clip are the bytes that umax run makes on one machine. With --vary there is a run for each "
              "combination of values in DIR/runs, and each waits for its own simulation alone. All machines must see "
              "DIR, the scene's files and this program under the same paths.\n\nA call that is killed or cannot write "
              "is gone on with inside its job; what a whole job has left is gone on with by the same command with "
              "--resume. umax farm status DIR says what is there, what is in the queue and what was lost; umax farm "
              "cancel DIR takes its jobs out of the queue. --threads and --memory are what each task asks the queue "
              "for; the environment's SBATCH_PARTITION, SBATCH_TIMELIMIT and others say more, and a task whose "
              "--deadline is over goes back into the queue. --dry-run prints scripts and commands. Another queue is a "
              "file of a few functions in bash: --queue FILE.",
          .examples = {"umax farm figure -o falling --frames-per-job 20 --threads 8 --memory 8G",
                       "umax farm figure --vary body.figure.limit.stretch=5%,10%,20% --dry-run",
                       "umax farm status falling"},
          .arguments = {.words = scenes_and_words, .endings = {"toml"}, .folders = true},
          .options = {"--output",  "--set",       "--vary",     "--frames-per-job", "--queue", "--dry-run",
                      "--resume",  "--overwrite", "--deadline", "--allow-overlap",  "--quick", "--engine",
                      "--samples", "--size",      "--seed",     "--threads",        "--isa",   "--memory",
                      "--json",    "--progress",  "--quiet"},
          .run = farm};
}

}  // namespace umax
