// Files of this folder that the program carries: queues, and what jobs do.
#pragma once

#include <string>

namespace umax {

/// The text of the file of this name: "slurm.sh".
std::string farm_file(const std::string& name);

}  // namespace umax
