#include "tools/cli/run_input.h"
#include "tools/cli/verbs.h"
#include "tools/run/job.h"

namespace umax {

int verb_drop(const Options& options) {
  Job job;
  job.scene = scene_of_mesh(single_input(options, "mesh"), 0.5, options);
  job.folder = output_folder(options, job.scene.name);
  job.existing = options.existing_folder();
  return do_job(job, options);
}

}  // namespace umax
