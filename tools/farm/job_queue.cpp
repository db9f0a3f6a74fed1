#include "tools/farm/job_queue.h"

#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/base/trimmed.h"
#include "core/files/read_file.h"
#include "tools/farm/farm_files.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace {

using Words = std::vector<std::string>;

/// Without line ends around it.
std::string said_in(const std::string& text) {
  return std::string(trimmed(text, " \n"));
}

/// Calls one of the functions. before: put in front of the call.
ProcessResult call(const QueueFunctions& queue, const Words& words, const std::string& before = {}) {
  Words command{"bash", "-c", queue + "\n" + before + "\"$@\"", "queue"};
  command.insert(command.end(), words.begin(), words.end());
  return run_process(command);
}

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& remedy) {
  throw Error(Fault::unavailable, {.where = where, .what = what, .remedy = remedy});
}

/// What a function prints, which must end well.
std::string answer(const QueueFunctions& queue, const Words& words, const std::string& before = {}) {
  const ProcessResult result = call(queue, words, before);
  if (result.exit_code == 0) return result.output;
  const std::string said = said_in(result.messages);
  refuse("the queue's function " + words.front(),
         fmt::format("failed with exit code {}{}{}", result.exit_code, said.empty() ? "" : ": ", said),
         "look at the queue, and at queue.sh in the farm's folder");
}

Words submission(const QueueJob& job) {
  Words words{"submit", std::to_string(job.tasks), job.after};
  words.insert(words.end(), job.words.begin(), job.words.end());
  return words;
}

std::vector<Words> lines_of_words(const std::string& text) {
  std::vector<Words> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream rest(line);
    Words words;
    for (std::string word; rest >> word;) words.push_back(word);
    if (!words.empty()) lines.push_back(words);
  }
  return lines;
}

}  // namespace

QueueFunctions queue_functions(const std::string& queue) {
  if (queue == "slurm" || queue == "here") return farm_file(queue + ".sh");
  return read_file(queue);
}

void require_queue(const QueueFunctions& queue) {
  for (const Words& line : lines_of_words(answer(queue, {"queue_programs"})))
    for (const std::string& program : line)
      if (!find_program(program))
        refuse(program, "is not in PATH, and is how jobs come into the queue",
               "call umax farm where jobs are submitted (Slurm: its package slurm-client), name another queue by "
               "--queue, or see what would be submitted by --dry-run");
}

std::string job_header(const QueueFunctions& queue, const std::string& name, const std::string& log,
                       const TaskShare& share) {
  constexpr long long mebibyte = 1 << 20;
  return answer(queue, {"job_header", name, log, std::to_string(share.processors),
                        std::to_string((share.memory + mebibyte - 1) / mebibyte)});
}

std::string submit_job(const QueueFunctions& queue, const QueueJob& job) {
  const ProcessResult result = call(queue, submission(job));
  const std::string id = said_in(result.output);
  if (result.exit_code == 0 && !id.empty() && id.find_first_of(" \n:") == std::string::npos) return id;
  const std::string said = said_in(result.messages);
  refuse(
      "job " + job.name,
      "is not taken by the queue: " + (said.empty() ? fmt::format("exit code {}, \"{}\"", result.exit_code, id) : said),
      "mend that and call umax farm again with --resume");
}

std::string submit_command(const QueueFunctions& queue, const QueueJob& job) {
  return said_in(answer(queue, submission(job), "UMAX_DRY_RUN=1 "));
}

std::vector<QueuedTask> unfinished_tasks(const QueueFunctions& queue) {
  std::vector<QueuedTask> tasks;
  for (const Words& line : lines_of_words(answer(queue, {"unfinished_tasks"})))
    tasks.push_back({line.front(), line.size() > 1 ? line[1] : "unfinished"});
  return tasks;
}

void cancel_jobs(const QueueFunctions& queue, const std::vector<std::string>& ids) {
  Words words{"cancel"};
  words.insert(words.end(), ids.begin(), ids.end());
  answer(queue, words);
}

}  // namespace umax
