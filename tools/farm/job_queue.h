// A queue of jobs, spoken to by the functions of a file in bash: slurm.sh says what each of them is for.
#pragma once

#include <string>
#include <vector>

namespace umax {

/// The functions' text.
using QueueFunctions = std::string;

/// Those of "slurm", of "here" (this machine), or of a file. Throws Error (not_found, io_error).
QueueFunctions queue_functions(const std::string& queue);

/// Throws Error (unavailable) that names the queue's programs that are not in PATH.
void require_queue(const QueueFunctions& queue);

/// What a task gets of its machine; 0: as the queue gives it.
struct TaskShare {
  int processors = 0;
  long long memory = 0;  // [bytes]
};

/// Lines at the head of a job's script. log: the beginning of the files for what its tasks say.
std::string job_header(const QueueFunctions& queue, const std::string& name, const std::string& log,
                       const TaskShare& share);

/// What is submitted.
struct QueueJob {
  std::string name;  // for messages
  int tasks = 1;
  std::string after = "-";         // "all:ID", "each:ID:ID": see slurm.sh
  std::vector<std::string> words;  // its script, and the words behind it
};

/// Returns the number that the queue gives it. Throws Error (unavailable) with what the queue says.
std::string submit_job(const QueueFunctions& queue, const QueueJob& job);

/// The command that submit_job() would give.
std::string submit_command(const QueueFunctions& queue, const QueueJob& job);

/// A task that is in the queue, or runs.
struct QueuedTask {
  std::string job;    // its array's number
  std::string state;  // "RUNNING", as the queue has it
};
/// Throws Error (unavailable) when the queue does not answer.
std::vector<QueuedTask> unfinished_tasks(const QueueFunctions& queue);

/// Throws Error (unavailable) with what the queue says.
void cancel_jobs(const QueueFunctions& queue, const std::vector<std::string>& ids);

}  // namespace umax
