#include "tools/python/run_reader.h"

#include "core/base/error.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_scene.h"
#include "tools/run/steps_csv.h"

namespace umax {

std::shared_ptr<RunReader> open_run(const std::filesystem::path& folder) {
  const Scene scene = scene_of_run(folder, {});
  return std::make_shared<RunReader>(RunReader{std::filesystem::absolute(folder), set_up(scene)});
}

int num_frames(const RunReader& run) {
  return count_states(run.folder);
}

RunFrame read_frame(const std::shared_ptr<RunReader>& run, int number) {
  const int count = num_frames(*run);
  if (number < 1 || number > count)
    throw Error(Fault::not_found,
                {.where = run->folder.string(),
                 .what = "has no such frame",
                 .value = std::to_string(number),
                 .remedy = count == 0 ? "simulate it first" : "its frames are 1 to " + std::to_string(count)});
  return {run, number, read_state(state_path(run->folder, number), run->simulation.model, run->simulation.digest)};
}

std::map<std::string, std::vector<double>> step_columns(const RunReader& run) {
  StepsFound found = read_steps(run.folder / "steps.csv", steps_header(probe_names(run.simulation.scene)));
  std::map<std::string, std::vector<double>> columns = std::move(found.columns);
  columns.erase("status");
  columns["converged"].assign(found.converged.begin(), found.converged.end());
  return columns;
}

}  // namespace umax
