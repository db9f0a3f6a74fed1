#include "tools/reproduce/workbench.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "render/image/image_io.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/pictures/painter.h"
#include "tools/pictures/shot.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/setup/camera_framing.h"
#include "tools/system/signals.h"

namespace umax {
namespace {

/// Whether the folder holds this whole run, and who made it had the time to finish it.
bool is_complete(const Simulation& simulation, const std::filesystem::path& folder) {
  const auto record = read_run_record(folder / "run.json");
  return record && record->model_sha256 == simulation.digest && record->frames == simulation.last_frame() &&
         record->exit_status == 0 && !is_abandoned(folder) && count_states(folder) >= simulation.last_frame();
}

/// What is there is another run's: another version of the experiment, another mesh.
bool is_stale(const Simulation& simulation, const std::filesystem::path& folder) {
  const auto record = read_run_record(folder / "run.json");
  return record && record->model_sha256 != simulation.digest;
}

}  // namespace

State Run::state(int frame) const {
  return read_state(state_path(folder, frame), simulation->model, simulation->digest);
}

std::vector<std::string> armadillo_settings_of(const std::vector<std::string>& settings) {
  bool has_mesh = false;
  for (const std::string& setting : settings) {
    const std::string key = parse_override(setting).key;
    has_mesh = has_mesh || key == "body.armadillo.mesh";
    if (key != "body.armadillo.mesh" && key != "body.armadillo.unit" && key != "body.armadillo.up")
      throw Error(Fault::usage, {.where = "--set " + setting,
                                 .what = "umax reproduce takes body.armadillo.mesh, .unit and .up only",
                                 .remedy = "the experiments are the paper's; run others with umax run"});
  }
  return has_mesh ? settings : std::vector<std::string>();
}

Workbench::Workbench(ReportFolder& folder, const ReportOptions& options, Progress& progress)
    : folder_(folder), options_(options), progress_(progress) {}

Run Workbench::simulate(const std::string& name, const std::string& scene, const std::vector<std::string>& settings) {
  std::vector<Override> overrides;
  for (const std::string& setting : settings) overrides.push_back(parse_override(setting));
  Run run;
  run.folder = folder_.runs() / name;
  run.simulation = std::make_shared<const Simulation>(set_up(load_scene(scene, overrides)));
  if (!is_complete(*run.simulation, run.folder)) {
    const bool stale = is_stale(*run.simulation, run.folder);
    progress_.note("run " + name + (stale ? ": what is there was made with other settings and is made anew" : ""));
    Job job;
    job.scene = run.simulation->scene;
    job.simulation = run.simulation;
    job.folder = run.folder;
    job.existing = stale ? ExistingFolder::overwrite : ExistingFolder::keep;
    job.pictures = false;
    create_folder(folder_.runs());
    if (do_job(job, options_.run, progress_) != 0) throw Interrupted{stop_signal()};
  }
  run.steps = read_steps(run.folder / "steps.csv", steps_header(probe_names(run.simulation->scene)));
  return run;
}

std::filesystem::path Workbench::paint(const std::string& name, const Tile& tile, const RenderDescription& render) {
  const std::filesystem::path png = folder_.tiles() / (name + ".png");
  const std::string digest =
      sha256_hex(fmt::format("{} {} {} {}", tile.key, render.width, render.height, render.samples));
  if (folder_.has_picture(png, digest)) return png;
  create_folder(folder_.tiles());
  if (!Painter(render, options_.run.threads).paint(tile.shot(double(render.width) / render.height), png))
    throw Interrupted{stop_signal()};
  folder_.set_picture(png, digest);
  return png;
}

std::filesystem::path Workbench::sheet(const std::string& name, const std::vector<Tile>& tiles, const SheetSize& size) {
  RenderDescription render;
  render.width = quick() ? size.width / 2 : size.width;
  render.height = quick() ? size.height / 2 : size.height;
  render.samples = options_.samples.value_or(quick() ? 8 : size.samples);
  std::vector<LabelledImage> images;
  progress_.begin("pictures of " + name, int(tiles.size()));
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const std::filesystem::path png = paint(fmt::format("{}-{}", name, i + 1), tiles[i], render);
    images.push_back({read_png8(png), tiles[i].label});
    for (const TileNote& note : tiles[i].notes)
      draw_label(images.back().image, note.text, float(note.x), float(note.y),
                 {.color = Vector3f(0.1f, 0.1f, 0.12f), .backed = false});
    progress_.frame_done(int(i) + 1);
  }
  progress_.end();
  const std::filesystem::path png = folder_.path() / (name + ".png");
  write_png(png, contact_sheet(images, size.columns));
  folder_.set_picture(png, "sheet");
  return png;
}

Tile tile_of(const Run& run, int frame, const std::string& label) {
  Tile tile;
  tile.label = label;
  tile.key = sha256_hex(fmt::format("{}{}{}", resolved_toml(run.simulation->scene), run.simulation->digest, frame));
  tile.shot = [run, frame](double aspect) {
    const State state = run.state(frame);
    const Box box = box_of(*run.simulation, state.positions);
    return make_shot(*run.simulation, make_stage(*run.simulation, box), state,
                     frame_camera(run.simulation->scene.camera, box, aspect));
  };
  return tile;
}

}  // namespace umax
