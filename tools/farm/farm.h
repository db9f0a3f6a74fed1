// Hands a scene to a queue of jobs that simulate, draw and encode it on many machines, with the bytes of one.
#pragma once

#include <filesystem>
#include <string>

#include "tools/farm/farm_plan.h"
#include "tools/farm/job_queue.h"
#include "tools/system/locked_folder.h"
#include "tools/system/progress.h"

namespace umax {

/// Writes the scripts into the folder and submits the jobs; what a queue refuses, none of the farm stays in it. Throws
/// Error: unavailable without the queue's programs, before anything is written, or when it does not take a job; try_again
/// while jobs of the folder's farm are in the queue; what make_farm_folder() throws.
void submit_farm(const FarmPlan& plan, const std::filesystem::path& folder, ExistingFolder existing,
                 const QueueFunctions& queue, Progress& progress);

/// The scripts and the commands that would submit them. Writes nothing and asks no queue.
std::string farm_dry_run(const FarmPlan& plan, const std::filesystem::path& folder, const QueueFunctions& queue);

/// Takes what is left of the farm out of its queue; returns the number of tasks. Throws Error: not_found where there is no
/// farm, unavailable when the queue does not do it.
int cancel_farm(const std::filesystem::path& folder);

}  // namespace umax
