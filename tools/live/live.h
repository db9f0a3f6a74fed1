// umax live as a call: a session in a folder, served until a signal comes.
#pragma once

#include <filesystem>

#include "scenes/scene.h"
#include "tools/system/locked_folder.h"
#include "tools/system/progress.h"

namespace umax {

struct LiveOptions {
  std::filesystem::path folder;
  ExistingFolder existing = ExistingFolder::refuse;
  int port = 0;         // 0: any that is free
  int keep = 3600;      // frames whose states stay on the disk
  bool browser = true;  // open one, where there is one
};

/// Returns the exit code. Throws Error: what set_up(), Recording and serve() throw.
int run_live(const Scene& scene, const LiveOptions& options, Progress& progress);

}  // namespace umax
