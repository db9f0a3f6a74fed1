#include "tools/run/export_run.h"

#include <fmt/format.h>

#include "tools/run/render_frames.h"

namespace umax {

ExportResult export_run(const Simulation& simulation, const std::filesystem::path& run, const std::vector<int>& frames,
                        const std::filesystem::path& folder, const ExportOptions& options, Progress& progress) {
  require_states(run, frames);
  const ClipSource source{
      .state = [&](int frame) { return read_state(state_path(run, frame), simulation.model, simulation.digest); },
      .camera = [&] { return camera_of_run(simulation, run); }};
  if (traits_of(options.format).has_camera && simulation.scene.camera.moves())
    progress.note("the camera moves; exports have it where it is at time 0");
  ExportResult result = export_clip(simulation, source, frames, folder, options, progress);
  if (result.signal == 0)
    progress.note(fmt::format("{}: {} ({} frames)", traits_of(options.format).name, folder.string(), frames.size()));
  return result;
}

}  // namespace umax
