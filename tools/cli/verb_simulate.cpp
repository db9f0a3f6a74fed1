#include "scenes/scene_file.h"
#include "tools/cli/verbs.h"
#include "tools/run/job.h"

namespace umax {

int verb_simulate(const Options& options) {
  Job job;
  job.scene = load_scene(single_input(options, "scene"), scene_overrides(options));
  job.folder = output_folder(options, job.scene.name);
  job.existing = options.existing_folder();
  job.pictures = false;
  return do_job(job, options);
}

}  // namespace umax
