// The scripts of a farm's jobs: plain files that a studio can read, change and submit by hand.
#pragma once

#include <string>
#include <vector>

#include "tools/farm/farm_folder.h"
#include "tools/farm/farm_plan.h"
#include "tools/farm/job_queue.h"

namespace umax {

struct FarmScript {
  std::string name;  // of its file in DIR/farm
  std::string text;
};

/// queue.sh, task.sh, which the others read, and those of the jobs: simulate.sh, render.sh, encode.sh. program: the path
/// of umax on all machines.
std::vector<FarmScript> farm_scripts(const FarmPlan& plan, const FarmPaths& paths, const QueueFunctions& queue,
                                     const std::string& program);

}  // namespace umax
